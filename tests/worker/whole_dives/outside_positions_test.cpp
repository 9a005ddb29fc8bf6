#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "tests/temporary_folder.hpp"
#include "worker/dive/dive.hpp"
#include "worker/io/geographic_frame.hpp"
#include "worker/pipeline/reconstruct_dive.hpp"
#include "worker/simulator/inertial_sensors.hpp"
#include "worker/simulator/outside_sensors.hpp"
#include "worker/simulator/simulate.hpp"

namespace divemesh::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kSeed = 3;

// A dive that looks into open water for six seconds, with positions by a USBL and a DVL.
class OutsidePositionsTest : public testing::Test {
protected:
    static void SetUpTestSuite() {
        folder_ = std::make_unique<TemporaryFolder>();
        simulator::SimulateOptions options{.scene = simulator::SceneKind::Reef,
                                           .out = *folder_ / "dive",
                                           .length_m = 8.0,
                                           .rate_hz = 5.0,
                                           .seed = kSeed,
                                           .width_px = 320,
                                           .height_px = 240};
        options.blue_water = simulator::stretches_from_string("0.4:6");
        options.positions = types::PositionKind::Usbl;
        options.dvl = true;
        simulator::simulate(options);
    }
    static void TearDownTestSuite() { folder_.reset(); }

    static void copy_dive(const std::string& name) {
        fs::copy(*folder_ / "dive", *folder_ / name, fs::copy_options::recursive);
    }
    static void leave_out(const std::string& name, const std::string& sensor) {
        fs::remove_all(*folder_ / name / "mav0" / sensor);
    }
    // Changes the numbers of every row after its timestamp.
    static void alter(const std::string& name,
                      const std::string& sensor,
                      const std::function<void(std::vector<double>&)>& change) {
        const fs::path file = *folder_ / name / "mav0" / sensor / "data.csv";
        std::ifstream in(file);
        std::ostringstream out;
        out.precision(12);
        for (std::string line; std::getline(in, line);) {
            std::istringstream fields(line);
            std::string field;
            std::getline(fields, field, ',');
            out << field;
            if (!field.starts_with('#')) {
                std::vector<double> values;
                for (std::string value; std::getline(fields, value, ',');)
                    values.push_back(std::stod(value));
                change(values);
                for (const double value : values) out << ',' << value;
            }
            out << '\n';
        }
        in.close();
        std::ofstream(file) << out.str();
    }
    static nlohmann::json reconstruct(const std::string& name) {
        return reconstruct_dive({.dive = *folder_ / name,
                                 .out = *folder_ / (name + "_model"),
                                 .scratch = *folder_ / (name + "_scratch"),
                                 .resumable = false,
                                 .options = make_options("standard", {{"surface", false}})},
                                base::ignore_progress);
    }
    static std::string path_of(const std::string& name) {
        std::ifstream file(*folder_ / (name + "_model") / "trajectory.tum");
        return {std::istreambuf_iterator<char>(file), {}};
    }
    static bool has(const nlohmann::json& metrics, const std::string& code) {
        return std::ranges::any_of(metrics["findings"],
                                   [&](const auto& finding) { return finding["code"] == code; });
    }

    static inline std::unique_ptr<TemporaryFolder> folder_;
};

TEST_F(OutsidePositionsTest, PutBothSidesOfOpenWaterIntoOneWorldWithinTheStatedBound) {
    const auto metrics = reconstruct("dive");

    ASSERT_EQ(metrics["pieces"].size(), 1U);
    EXPECT_FALSE(has(metrics, "dive_in_segments"));
    EXPECT_EQ(metrics["georeference"]["num_joined_segments"], 1);
    const double end_m = metrics["trajectory"]["final"]["end_drift_m"];
    EXPECT_LT(end_m, 0.06);
    EXPECT_LT(end_m, metrics["expected_accuracy"]["trajectory"]["end_position"]["bound_m"]);
    EXPECT_LT(metrics["trajectory"]["final"]["ate_rmse_m"], 0.03);
}

TEST_F(OutsidePositionsTest, TellPlaceAndHeadingWithinTheirSigmas) {
    const auto geo = reconstruct("dive")["georeference"];

    const types::GeographicPosition place = simulator::place_on_earth(kSeed);
    const auto dive = dive::Dive::open(*folder_ / "dive", *folder_ / "opened");
    const auto first = std::ranges::lower_bound(
        dive->ground_truth(), simulator::kFirstFrame_ns, {}, &types::StampedPose::timestamp_ns);
    const Eigen::Vector3d start = first->T_world_imu.translation();
    const Eigen::Vector2d start_utm_m =
        io::utm_frame(place).A * Eigen::Vector3d(start.x(), start.y(), 1.0);
    EXPECT_EQ(geo["epsg"], io::utm_frame(place).epsg);
    EXPECT_NEAR(geo["easting_m"], start_utm_m.x(), 3.5 * geo["easting_sigma_m"].get<double>());
    EXPECT_NEAR(geo["northing_m"], start_utm_m.y(), 3.5 * geo["northing_sigma_m"].get<double>());
    EXPECT_LT(geo["easting_sigma_m"], 0.3);
    EXPECT_NEAR(
        geo["x_azimuth_deg"], *place.x_azimuth_deg, 3.5 * geo["heading_sigma_deg"].get<double>());
    EXPECT_LT(geo["heading_sigma_deg"], 5.0);
}

TEST_F(OutsidePositionsTest, MirroredPositionsAndVelocitiesInAnotherUnitChangeNothing) {
    copy_dive("none");
    leave_out("none", "position0");
    leave_out("none", "velocity0");
    const auto none = reconstruct("none");
    ASSERT_EQ(none["pieces"].size(), 2U) << "the IMU bridged the gap";
    EXPECT_FALSE(none.contains("georeference"));

    copy_dive("wrong");
    alter("wrong", "position0", [](std::vector<double>& row) { row[0] = 427890.0 - row[0]; });
    alter("wrong", "velocity0", [](std::vector<double>& row) {
        for (std::size_t axis = 0; axis < 3; ++axis) row[axis] *= 1.94;  // knots
    });
    const auto wrong = reconstruct("wrong");
    EXPECT_TRUE(has(wrong, "positions_left_out"));
    ASSERT_EQ(wrong["georeference"]["sources"].size(), 2U);
    for (const auto& source : wrong["georeference"]["sources"]) {
        EXPECT_TRUE(source.contains("left_out")) << source;
        EXPECT_EQ(source["num_used"], 0);
    }
    EXPECT_FALSE(wrong["dive"].contains("position"));
    EXPECT_EQ(wrong["pieces"].size(), 2U);
    EXPECT_EQ(path_of("wrong"), path_of("none"));
}

}  // namespace
}  // namespace divemesh::pipeline
