#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "tests/temporary_folder.hpp"
#include "worker/markers/marker_positions.hpp"
#include "worker/markers/world_scale.hpp"
#include "worker/output/reconstruction_folder.hpp"
#include "worker/reconstruct_dive.hpp"
#include "worker/simulator/dive_files.hpp"
#include "worker/simulator/draw_rig.hpp"
#include "worker/simulator/simulate.hpp"

namespace divemesh::worker {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth_px = 480;
constexpr int kHeight_px = 360;
constexpr double kStatedTooLong = 1.01;

// A dive over six tags whose calibration states a baseline that is one percent too long.
class MarkedDiveTest : public testing::Test {
protected:
    static void SetUpTestSuite() {
        folder_ = std::make_unique<TemporaryFolder>();
        simulate({.scene = SceneKind::Barge,
                  .out = *folder_ / "dive",
                  .length_m = 2.5,
                  .water = WaterKind::Green,
                  .width_px = kWidth_px,
                  .height_px = kHeight_px,
                  .num_markers = 6,
                  .marker_size_m = 0.16});
        const Rig rig = WorldScale(kStatedTooLong, Eigen::Isometry3d::Identity())
                            .applied(draw_rig(kWidth_px, kHeight_px, 1));
        write_camera_files(*folder_ / "stated", rig.cam1, rig.T_imu_cam1, 10.0, {});
        fs::copy_file(*folder_ / "stated" / "sensor.yaml",
                      *folder_ / "dive" / "mav0" / "cam1" / "sensor.yaml",
                      fs::copy_options::overwrite_existing);
    }
    static void TearDownTestSuite() { folder_.reset(); }

    static nlohmann::json reconstruct(const std::string& name, const nlohmann::json& options) {
        return reconstruct_dive({.dive = *folder_ / "dive",
                                 .out = *folder_ / name,
                                 .scratch = *folder_ / (name + "_scratch"),
                                 .resumable = false,
                                 .options = make_options("standard", options)},
                                ignore_progress);
    }

    static inline std::unique_ptr<TemporaryFolder> folder_;
};

TEST_F(MarkedDiveTest, AWrongBaselineIsToldAndNothingIsScaledUnasked) {
    const auto metrics = reconstruct("as_stated", {{"surface", false}});

    const auto& scale = metrics["markers"]["scale"];
    EXPECT_NEAR(scale["factor"].get<double>(), 1.0 / kStatedTooLong, 0.003);
    EXPECT_FALSE(metrics["markers"].contains("scale_correction"));
    EXPECT_TRUE(std::any_of(metrics["findings"].begin(),
                            metrics["findings"].end(),
                            [](const auto& finding) { return finding["code"] == "scale_off"; }));
}

TEST_F(MarkedDiveTest, CorrectedLengthsAreRightInEverythingThatIsGivenOut) {
    const auto metrics = reconstruct("corrected", {{"correct_scale", true}});

    const auto& markers = metrics["markers"];
    EXPECT_TRUE(markers["scale_correction"]["applied"]);
    EXPECT_GE(markers["num_bars_measured"], 10);
    for (const auto& bar : markers["bars"]) {
        if (bar["measured_m"].is_null() || bar["known_m"] <= 0.3) continue;
        EXPECT_LT(std::abs(bar["error_percent"].get<double>()), 0.5) << bar["name"];
    }
    // The path by the ground truth's own scale.
    EXPECT_NEAR(metrics["trajectory"]["final"]["sim3_scale"].get<double>(), 1.0, 0.004);
    const ReconstructionFolder folder(*folder_ / "corrected");
    const Mesh mesh = folder.mesh();
    for (const MarkerPosition& marker : marker_positions(folder)) {
        float nearest_m = std::numeric_limits<float>::max();
        for (const Eigen::Vector3f& vertex : mesh.vertices)
            nearest_m = std::min(nearest_m, (vertex - marker.p_world.cast<float>()).norm());
        EXPECT_LT(nearest_m, 0.01) << marker.id;
    }
}

}  // namespace
}  // namespace divemesh::worker
