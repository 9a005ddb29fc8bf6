#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <random>

#include "tests/temporary_folder.hpp"
#include "worker/compare/marker_positions.hpp"
#include "worker/dive/dive.hpp"
#include "worker/evaluation/known_distances.hpp"
#include "worker/evaluation/surface_index.hpp"
#include "worker/io/reconstruction_folder.hpp"
#include "worker/markers/world_scale.hpp"
#include "worker/pipeline/reconstruct_dive.hpp"
#include "worker/simulator/dive_files.hpp"
#include "worker/simulator/draw_rig.hpp"
#include "worker/simulator/simulate.hpp"

namespace divemesh::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth_px = 480;
constexpr int kHeight_px = 360;
constexpr double kStatedTooLong = 1.01;

// A dive over eight tags whose calibration states a baseline that is one percent too long.
class MarkedDiveTest : public testing::Test {
protected:
    static void SetUpTestSuite() {
        folder_ = std::make_unique<TemporaryFolder>();
        simulator::simulate({.scene = simulator::SceneKind::Barge,
                             .out = *folder_ / "dive",
                             .length_m = 2.5,
                             .water = simulator::WaterKind::Green,
                             .width_px = kWidth_px,
                             .height_px = kHeight_px,
                             .num_markers = 8,
                             .marker_size_m = 0.2});
        const types::Rig rig = markers::WorldScale(kStatedTooLong, Eigen::Isometry3d::Identity())
                                   .applied(simulator::draw_rig(kWidth_px, kHeight_px, 1));
        simulator::write_camera_files(*folder_ / "stated", rig.cam1, rig.T_imu_cam1, 10.0, {});
        fs::copy_file(*folder_ / "stated" / "sensor.yaml",
                      *folder_ / "dive" / "mav0" / "cam1" / "sensor.yaml",
                      fs::copy_options::overwrite_existing);
    }
    static void TearDownTestSuite() { folder_.reset(); }

    // Tracks a dive once for all options that change only what follows.
    static nlohmann::json reconstruct(const std::string& name, const nlohmann::json& options) {
        return pipeline::reconstruct_dive({.dive = *folder_ / "dive",
                                           .out = *folder_ / name,
                                           .scratch = *folder_ / (name + "_scratch"),
                                           .cache = *folder_ / "cache",
                                           .cache_bytes = 1'000'000'000,
                                           .resumable = false,
                                           .options = make_options("standard", options)},
                                          base::ignore_progress);
    }

    static inline std::unique_ptr<TemporaryFolder> folder_;
};

TEST_F(MarkedDiveTest, AWrongBaselineIsToldAndNothingIsScaledUnasked) {
    const auto metrics = reconstruct("as_stated", {{"surface", false}, {"correct_scale", "off"}});

    const auto& scale = metrics["markers"]["scale"];
    EXPECT_NEAR(scale["factor"].get<double>(), 1.0 / kStatedTooLong, 0.003);
    EXPECT_FALSE(metrics["markers"].contains("scale_correction"));
    EXPECT_TRUE(std::any_of(metrics["findings"].begin(),
                            metrics["findings"].end(),
                            [](const auto& finding) { return finding["code"] == "scale_off"; }));
}

TEST_F(MarkedDiveTest, AWrongBaselineIsCorrectedWhereTheMarkersContradictIt) {
    const auto metrics = reconstruct("auto", {{"surface", false}});

    const auto& correction = metrics["calibration"]["scale_correction"];
    EXPECT_NEAR(correction["factor"].get<double>(), 1.0 / kStatedTooLong, 0.003);
    EXPECT_TRUE(correction["sources"].contains("markers"));
    const auto& path = metrics["trajectory"]["final"];
    EXPECT_NEAR(path["sim3_scale"].get<double>(), 1.0, 0.004);
    const double sigma = metrics["calibration"]["scale_sigma"];
    // The correction's own, with what the drift of the poses adds.
    EXPECT_GE(sigma * correction["factor"].get<double>(), correction["sigma"].get<double>());
    EXPECT_LT(sigma, 0.004);
    EXPECT_LT(std::abs(path["sim3_scale"].get<double>() - 1.0), 3.0 * sigma);
    const auto& bounds = metrics["expected_accuracy"]["trajectory"];
    EXPECT_LT(path["ate_rmse_m"].get<double>(), bounds["ate"]["bound_m"].get<double>());
    EXPECT_LT(path["end_drift_m"].get<double>(), bounds["end_position"]["bound_m"].get<double>());
    const double true_m = simulator::draw_rig(kWidth_px, kHeight_px, 1).baseline_m();
    const types::Rig used = io::ReconstructionFolder(*folder_ / "auto").rig().value();
    EXPECT_NEAR(used.baseline_m() / true_m, 1.0, 3.0 * sigma);
    EXPECT_TRUE(std::any_of(
        metrics["findings"].begin(), metrics["findings"].end(), [](const auto& finding) {
            return finding["code"] == "scale_corrected";
        }));
}

TEST_F(MarkedDiveTest, CorrectedLengthsAreRightInEverythingThatIsGivenOut) {
    const auto metrics = reconstruct("corrected", {{"correct_scale", true}});

    const auto& markers = metrics["markers"];
    EXPECT_TRUE(markers["scale_correction"]["applied"]);
    EXPECT_GE(markers["num_bars_measured"], 10);
    int num_long_bars = 0;
    for (const auto& bar : markers["bars"]) {
        if (bar["measured_m"].is_null() || bar["known_m"] <= 0.3) continue;
        ++num_long_bars;
        EXPECT_LT(std::abs(bar["error_percent"].get<double>()), 0.5) << bar["name"];
    }
    EXPECT_GE(num_long_bars, 1);
    // The path's scale relative to the ground truth.
    EXPECT_NEAR(metrics["trajectory"]["final"]["sim3_scale"].get<double>(), 1.0, 0.004);
    const io::ReconstructionFolder folder(*folder_ / "corrected");
    const types::Mesh mesh = folder.mesh();
    const auto positions = compare::marker_positions(folder);
    ASSERT_FALSE(positions.empty());
    for (const compare::MarkerPosition& marker : positions) {
        float nearest_m = std::numeric_limits<float>::max();
        for (const Eigen::Vector3f& vertex : mesh.vertices)
            nearest_m = std::min(nearest_m, (vertex - marker.p_world.cast<float>()).norm());
        EXPECT_LT(nearest_m, 0.01) << marker.id;
    }
}

// Marks the known distances of a dive where its true cameras saw them, to a third of a pixel.
void mark_known_distances(const fs::path& folder, const fs::path& scratch) {
    const auto dive = dive::Dive::open(folder, scratch);
    const types::Mesh surface = dive->read_reference_mesh().value();
    const evaluation::SurfaceIndex reference(surface);
    std::vector<std::int64_t> timestamps_ns;
    for (int i = 0; i < dive->num_frames(); i += 2)
        timestamps_ns.push_back(dive->frame(i).value().timestamp_ns);
    const types::Trajectory truth = dive->ground_truth();
    const types::Rig rig = simulator::draw_rig(kWidth_px, kHeight_px, 1);
    std::mt19937 random(1);
    std::normal_distribution<double> noise_px(0.0, 0.3);
    const auto marked = [&](const Eigen::Vector3d& p_world) {
        nlohmann::json marks = nlohmann::json::array();
        for (const dive::Mark& mark :
             evaluation::mark_point(p_world, {rig, truth, timestamps_ns, reference})) {
            if (!mark.pixel_right) continue;
            const auto read = [&](const Eigen::Vector2d& pixel) {
                return nlohmann::json{pixel.x() + noise_px(random), pixel.y() + noise_px(random)};
            };
            marks.push_back({{"timestamp_ns", mark.timestamp_ns},
                             {"left", read(mark.pixel_left)},
                             {"right", read(*mark.pixel_right)}});
        }
        return marks;
    };
    nlohmann::json distances = nlohmann::json::array();
    for (const dive::KnownDistance& known : dive->known_distances()) {
        const nlohmann::json a = marked(known.a_world);
        const nlohmann::json b = marked(known.b_world);
        if (a.size() >= 4 && b.size() >= 4)
            distances.push_back({{"name", known.name},
                                 {"distance_m", known.distance_m},
                                 {"marks_a", a},
                                 {"marks_b", b}});
    }
    ASSERT_FALSE(distances.empty());
    std::ofstream(folder / "measurements.json") << nlohmann::json{{"distances", distances}};
}

TEST_F(MarkedDiveTest, LengthsMarkedByHandCorrectAWrongBaseline) {
    const fs::path dive = *folder_ / "marked_by_hand";
    fs::copy(*folder_ / "dive", dive, fs::copy_options::recursive);
    fs::remove(dive / "markers.json");
    ASSERT_NO_FATAL_FAILURE(mark_known_distances(dive, *folder_ / "marking"));
    const auto metrics =
        pipeline::reconstruct_dive({.dive = dive,
                                    .out = *folder_ / "by_hand",
                                    .scratch = *folder_ / "by_hand_scratch",
                                    .resumable = false,
                                    .options = make_options("standard", {{"surface", false}})},
                                   base::ignore_progress);
    const auto& correction = metrics["calibration"]["scale_correction"];
    ASSERT_TRUE(correction["sources"].contains("known_distances")) << metrics["expected_accuracy"];
    EXPECT_NEAR(metrics["trajectory"]["final"]["sim3_scale"].get<double>(), 1.0, 0.004);
}

double length_m(const types::Trajectory& path, std::size_t first, std::size_t last) {
    double sum = 0.0;
    for (std::size_t i = first + 1; i < last; ++i)
        sum += (path.at(i).T_world_imu.translation() - path.at(i - 1).T_world_imu.translation())
                   .norm();
    return sum;
}

bool is_interrupted(const types::StampedPose& before, const types::StampedPose& after) {
    return after.timestamp_ns - before.timestamp_ns > 1'000'000'000;
}

// Returns the distances between the markers of each segment.
std::vector<double> distances_m(const nlohmann::json& markers) {
    std::vector<double> distances;
    for (const auto& from : markers)
        for (const auto& to : markers) {
            if (from["piece"] != to["piece"] || from["id"] >= to["id"]) continue;
            const auto p = from["position_m"].get<std::array<double, 3>>();
            const auto q = to["position_m"].get<std::array<double, 3>>();
            distances.push_back(std::hypot(q[0] - p[0], q[1] - p[1], q[2] - p[2]));
        }
    return distances;
}

TEST_F(MarkedDiveTest, AllSegmentsOfADiveAreScaledByOneFactor) {
    // A cloud of silt for four seconds: what is seen before and after it does not overlap.
    constexpr std::size_t kFirstBlank = 22;
    constexpr std::size_t kAfterBlank = 60;
    const fs::path dive = *folder_ / "dive";
    fs::copy(dive, *folder_ / "clear", fs::copy_options::recursive);
    for (const char* camera : {"cam0", "cam1"}) {
        std::vector<fs::path> images;
        for (const auto& entry : fs::directory_iterator(dive / "mav0" / camera / "data"))
            images.push_back(entry.path());
        std::sort(images.begin(), images.end());
        const cv::Mat silt(kHeight_px, kWidth_px, CV_8UC3, cv::Scalar(90, 110, 60));
        for (std::size_t i = kFirstBlank; i < kAfterBlank; ++i)
            cv::imwrite(images.at(i).string(), silt);
    }
    nlohmann::json options = {
        {"surface", false}, {"use_imu", false}, {"use_ahrs", false}, {"close_loops", false}};
    options["correct_scale"] = "off";
    const auto stated = reconstruct("segments_as_stated", options);
    options["correct_scale"] = "on";
    const auto corrected = reconstruct("segments_corrected", options);
    fs::remove_all(dive);
    fs::rename(*folder_ / "clear", dive);

    ASSERT_EQ(corrected["pieces"].size(), 2U);
    ASSERT_TRUE(corrected["markers"]["scale_correction"]["applied"]);
    const double factor = corrected["markers"]["scale_correction"]["factor"];
    const types::Trajectory before =
        io::ReconstructionFolder(*folder_ / "segments_as_stated").trajectory();
    const types::Trajectory after =
        io::ReconstructionFolder(*folder_ / "segments_corrected").trajectory();
    const auto ratio = [&](std::size_t first, std::size_t last) {
        return length_m(after, first, last) / length_m(before, first, last);
    };
    const auto end_of_first = static_cast<std::size_t>(
        std::adjacent_find(after.begin(), after.end(), is_interrupted) - after.begin() + 1);
    ASSERT_LT(end_of_first + 5, after.size());
    EXPECT_NEAR(ratio(0, end_of_first), factor, 1e-3);
    EXPECT_NEAR(ratio(end_of_first, after.size()), factor, 1e-3);
    const auto as_stated = distances_m(stated["markers"]["markers"]);
    const auto as_corrected = distances_m(corrected["markers"]["markers"]);
    ASSERT_EQ(as_stated.size(), as_corrected.size());
    ASSERT_GE(as_stated.size(), 4U);
    for (std::size_t i = 0; i < as_stated.size(); ++i)
        EXPECT_NEAR(as_corrected[i] / as_stated[i], factor, 1e-3);
}

}  // namespace
}  // namespace divemesh::pipeline
