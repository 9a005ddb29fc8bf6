#include "worker/reef/measure_reconstruction.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "tests/temporary_folder.hpp"
#include "tests/worker/reef/sheets.hpp"
#include "worker/evaluation/scaled_uncertainty.hpp"
#include "worker/io/ply.hpp"
#include "worker/io/trajectory_file.hpp"

namespace divemesh::reef {
namespace {

using nlohmann::json;

// A result of level ground, 1 m x 1 m, that a rig saw from 2 m above its middle.
class MeasureReconstructionTest : public testing::Test {
protected:
    MeasureReconstructionTest() {
        io::write_tum(folder_ / "trajectory.tum", path());
        write("areas.json", R"({"areas": [{"name": "q", "corners": [[0.2, 0.2, 0], [0.8, 0.2, 0],
                                           [0.8, 0.8, 0], [0.2, 0.8, 0]]}]})");
        write("metrics.json", "{}");
        give_ground(0.01);
    }

    void write(const std::string& name, const std::string& text) const {
        std::ofstream(folder_ / name) << text;
    }
    static types::Trajectory path() {
        types::Trajectory trajectory(1);
        trajectory[0].T_world_imu.translation() = Eigen::Vector3d(0.5, 0.5, 2.0);
        return trajectory;
    }
    static types::Mesh level_ground(double cell_m) {
        types::Mesh mesh = sheet(1.0, cell_m, [](double, double) { return 0.0; });
        mesh.sigma_m.assign(mesh.vertices.size(), 0.002F);
        mesh.sigma_local_m = mesh.sigma_m;
        return mesh;
    }
    void give_ground(double cell_m) const {
        io::write_ply(folder_ / "mesh.ply", level_ground(cell_m));
    }
    json measure() const {
        return measure_reconstruction({folder_.path(), folder_ / "areas.json", std::nullopt});
    }

    TemporaryFolder folder_;
};

TEST_F(MeasureReconstructionTest, DetailIsThatOfTheImagesInWhichTheSurfaceWasMatched) {
    write("metrics.json",
          R"({"calibration": {"focal_px": [900, 900]}, "frames": {"reduction": 2}})");
    write("keyframes.json", R"({"focal_px": 300, "keyframes": []})");
    const json measured = measure();
    const double range_m = 2.02;  // the median over the quadrat
    EXPECT_NEAR(measured["areas"][1]["detail_m"].get<double>(), 15.0 * range_m / 300.0, 1e-3);
    EXPECT_TRUE(metric_of(measured, "q", "rugosity", 0.10).contains("refused"));
    EXPECT_TRUE(metric_of(measured, "q", "rugosity", 0.25).contains("value"));
}

TEST_F(MeasureReconstructionTest, ASimplifiedMeshIsAsCoarseAsItsTrianglesAndAsVagueAsItsError) {
    give_ground(0.05);
    write("keyframes.json", R"({"focal_px": 3000, "keyframes": []})");
    EXPECT_TRUE(metric_of(measure(), "q", "rugosity", 0.02).contains("value"));
    write("metrics.json", R"({"mesh": {"voxel_m": 0.004, "simplification":
        {"num_triangles_before": 9, "rms_m": 0.0015, "max_m": 0.01}}})");
    const json measured = measure();
    EXPECT_NEAR(measured["areas"][1]["sigma_m"].get<double>(), std::hypot(0.002, 0.0015), 1e-6);
    EXPECT_NEAR(measured["areas"][1]["detail_m"].get<double>(), 2.0 * 0.05, 1e-5);
    EXPECT_EQ(metric_of(measured, "q", "rugosity", 0.05).value("refused", ""),
              "finer than the detail of the surface, 100.0 mm");
}

TEST_F(MeasureReconstructionTest, ScaleIsAsCertainAsTheReconstructionStates) {
    const auto half_width = [&](const char* metric) {
        const json entry = metric_of(measure(), "q", metric);
        return 0.5 * (entry["high"].get<double>() - entry["low"].get<double>());
    };
    write("metrics.json", R"({"calibration": {"scale_sigma": 0.02}})");
    EXPECT_NEAR(half_width("planar_area"), 1.96 * 2.0 * 0.02 * 0.36, 1e-5);
    EXPECT_NEAR(half_width("longest_diameter"), 1.96 * 0.02 * 0.6 * std::sqrt(2.0), 1e-5);
    write("metrics.json", "{}");
    EXPECT_NEAR(half_width("planar_area"), 1.96 * 2.0 * types::kCalibrationSigma * 0.36, 1e-5);
}

TEST_F(MeasureReconstructionTest, TheVerdictAndWhatConcernsTheMetricsComeWithThem) {
    EXPECT_EQ(measure()["reconstruction"], json({{"findings", json::array()}}));
    write("metrics.json",
          R"({"verdict": "usable_with_restrictions", "restrictions": ["path", "scale"],
        "findings": [
        {"severity": "warning", "code": "tracking_lost", "where": "", "message": "m", "remedy": "r"},
        {"severity": "warning", "code": "scale_untested", "where": "", "message": "m", "remedy": "r"},
        {"severity": "info", "code": "scale_corrected", "where": "", "message": "m", "remedy": "r"}]})");
    const json judgement = measure()["reconstruction"];
    EXPECT_EQ(judgement["verdict"], "usable_with_restrictions");
    EXPECT_EQ(judgement["restrictions"], json({"path", "scale"}));
    ASSERT_EQ(judgement["findings"].size(), 1U);
    EXPECT_EQ(judgement["findings"][0]["code"], "scale_untested");
}

// Another measurement says that all lengths are 5 % longer.
TEST_F(MeasureReconstructionTest, AScaleThatContradictsIsInSizesButRoughensNothing) {
    constexpr double kContradiction = 0.05;
    const double sigma = evaluation::contradiction_sigma(kContradiction);
    types::Mesh mesh = level_ground(0.01);
    mesh.normals.assign(mesh.vertices.size(), Eigen::Vector3f::UnitZ());
    mesh = evaluation::with_scale_sigma(std::move(mesh), path(), {}, 0.0, sigma);
    EXPECT_GT(mesh.sigma_m[0], 0.05F);
    io::write_ply(folder_ / "mesh.ply", mesh);
    constexpr double kShared_m = 0.001;
    const double scale_sigma = std::hypot(0.002, sigma);
    write("metrics.json",
          json{{"calibration",
                {{"scale_sigma", scale_sigma}, {"scale_contradiction", kContradiction}}},
               {"expected_accuracy", {{"surface", {{"sigma_shared_m", kShared_m}}}}}}
              .dump());
    // Its plane is 0.1 m below the ground.
    write("areas.json", R"({"areas": [{"name": "q", "corners": [[0.2, 0.2, -0.1], [0.8, 0.2, -0.1],
                                       [0.8, 0.8, -0.1], [0.2, 0.8, -0.1]]}]})");
    const json measured = measure();
    const json diameter = metric_of(measured, "q", "longest_diameter");
    const double value_m = diameter["value"].get<double>();
    EXPECT_GT(diameter["high"].get<double>(), (1.0 + kContradiction) * value_m);
    EXPECT_LT(diameter["low"].get<double>(), (1.0 - kContradiction) * value_m);
    EXPECT_NEAR(measured["areas"][1]["sigma_m"].get<double>(), 0.002, 1e-5);
    const json volume = metric_of(measured, "q", "volume");
    const double half_m3 = 0.5 * (volume["high"].get<double>() - volume["low"].get<double>());
    const double expected_m3 = 1.96 * std::hypot(3.0 * scale_sigma * 0.036, kShared_m * 0.36);
    EXPECT_NEAR(volume["value"].get<double>(), 0.036, 1e-4);
    EXPECT_NEAR(half_m3, expected_m3, 0.05 * expected_m3);
}

}  // namespace
}  // namespace divemesh::reef
