#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/temporary_folder.hpp"
#include "worker/evaluation/trajectory_error.hpp"
#include "worker/io/trajectory_file.hpp"
#include "worker/pipeline/reconstruct_dive.hpp"
#include "worker/simulator/simulate.hpp"

namespace divemesh::pipeline {
namespace {

namespace fs = std::filesystem;

// Stills of a barge in green water, 27 cm from one to the next: a pair a second, without an IMU.
class SlowFramesTest : public testing::Test {
protected:
    SlowFramesTest() {
        simulator::simulate({.scene = simulator::SceneKind::Barge,
                             .out = dive_,
                             .length_m = 3.0,
                             .rate_hz = 1.0,
                             .seed = 5,
                             .width_px = 320,
                             .height_px = 240});
        fs::remove(dive_ / "reference.ply");  // a million samples take too long here
        metrics_ = reconstruct_dive(
            {.dive = dive_,
             .out = folder_ / "out",
             .scratch = folder_ / "scratch",
             .options = make_options(
                 "standard", {{"surface", false}, {"use_imu", false}, {"use_ahrs", false}})},
            base::ignore_progress);
    }

    double absolute_error_m() const {
        return evaluation::trajectory_error(
                   io::read_trajectory(folder_ / "out/trajectory.tum").poses,
                   io::read_trajectory(dive_ / "mav0/state_groundtruth_estimate0/data.csv").poses)
            .ate_rmse_m;
    }

    TemporaryFolder folder_;
    fs::path dive_ = folder_ / "dive";
    nlohmann::json metrics_;
};

TEST_F(SlowFramesTest, EachIsLinkedToTheOneBefore) {
    const nlohmann::json& frames = metrics_.at("frames");
    ASSERT_GE(frames.at("num_frames").get<int>(), 8);
    EXPECT_EQ(frames.at("num_frames_tracked"), frames.at("num_frames"));
    EXPECT_EQ(metrics_.at("pieces").size(), 1U);
    EXPECT_LT(absolute_error_m(), 0.005);
}

}  // namespace
}  // namespace divemesh::pipeline
