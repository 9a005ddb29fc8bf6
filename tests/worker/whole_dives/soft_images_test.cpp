#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/synthetic/altered_recording.hpp"
#include "tests/synthetic/pose_near.hpp"
#include "tests/worker/whole_dives/short_tank_dive.hpp"
#include "worker/camera/projection.hpp"
#include "worker/pipeline/reconstruct.hpp"
#include "worker/pipeline/reconstruct_dive.hpp"
#include "worker/pipeline/track_reduced.hpp"

namespace divemesh::pipeline {
namespace {

constexpr int kEnlarged = 4;

// A rendered dive as a camera of four times the resolution sees it through turbid water: what is
// finer than some pixels is lost, contrast is low, and the sensor's noise stays.
class SoftRecording : public synthetic::AlteredRecording {
public:
    explicit SoftRecording(types::Recording& recording)
        : AlteredRecording(recording,
                           [](types::StereoFrame& frame) {
                               soften(frame.left, 2 * frame.index);
                               soften(frame.right, 2 * frame.index + 1);
                           }),
          rig_(recording.rig()) {
        for (types::Camera* camera : {&rig_.cam0, &rig_.cam1}) {
            camera->width_px *= kEnlarged;
            camera->height_px *= kEnlarged;
            camera->fx_px *= kEnlarged;
            camera->fy_px *= kEnlarged;
            camera->cx_px = (camera->cx_px + 0.5) * kEnlarged - 0.5;
            camera->cy_px = (camera->cy_px + 0.5) * kEnlarged - 0.5;
        }
    }
    const types::Rig& rig() const override { return rig_; }

private:
    static void soften(cv::Mat& image, int seed) {
        cv::Mat large;
        cv::resize(image, large, {}, kEnlarged, kEnlarged, cv::INTER_CUBIC);
        cv::GaussianBlur(large, large, {}, 5.0);
        cv::Mat values;
        large.convertTo(values, CV_32F, 0.25, 80.0);
        cv::Mat noise(values.size(), CV_32F);
        cv::RNG(static_cast<std::uint64_t>(seed) + 1).fill(noise, cv::RNG::NORMAL, 0.0, 2.0);
        cv::Mat(values + noise).convertTo(image, CV_8U);
    }

    types::Rig rig_;
};

class SoftImagesTest : public ShortTankDive {
protected:
    static void SetUpTestSuite() { render(0.3); }
    SoftImagesTest() { options_.surface = false; }
    types::Track tracked(types::Recording& recording) const {
        recording.rewind();
        return track(recording,
                     options_,
                     keyframes::KeyframeStore(*folder_ / "keyframes"),
                     base::ignore_progress);
    }
    int reduction_of(AlignedRecording& recording) const {
        return better_reduction(
            tracked(recording), options_, *folder_ / "reduced", recording, base::ignore_progress);
    }
    static std::size_t num_by_vision(const types::Track& track) {
        return static_cast<std::size_t>(types::num_by_vision(track));
    }

    ReconstructionOptions options_;
};

TEST_F(SoftImagesTest, WhatIsLostAtFullSizeIsTrackedInReducedImages) {
    SoftRecording soft(*dive_);
    AlignedRecording recording(soft);

    const int reduction = reduction_of(recording);

    EXPECT_GT(reduction, 1);
    EXPECT_EQ(recording.reduction(), 1);
    EXPECT_FALSE(std::filesystem::exists(*folder_ / "reduced"));
    recording.set_reduction(reduction);
    const types::Track track = tracked(recording);
    ASSERT_GE(track.causal.size(), 8U);
    EXPECT_GE(num_by_vision(track), track.causal.size() - 2);
    const types::Trajectory& truth = dive_->ground_truth();
    const auto way = [](const types::Trajectory& path, std::int64_t from_ns, std::int64_t to_ns) {
        const auto at = [&](std::int64_t time_ns) {
            return std::find_if(
                       path.begin(),
                       path.end(),
                       [&](const types::StampedPose& pose) { return pose.timestamp_ns >= time_ns; })
                ->T_world_imu;
        };
        return Eigen::Isometry3d(at(from_ns).inverse() * at(to_ns));
    };
    const std::int64_t from_ns = track.causal.front().timestamp_ns;
    const std::int64_t to_ns = track.causal.back().timestamp_ns;
    EXPECT_THAT(way(track.causal, from_ns, to_ns),
                synthetic::IsPoseWithin(way(truth, from_ns, to_ns), 1.0, 0.03));
}

TEST_F(SoftImagesTest, WhatIsTrackedStaysAtFullSize) {
    AlignedRecording recording(*dive_);
    EXPECT_EQ(reduction_of(recording), 1);
}

TEST(WideImagesTest, AreReducedToTheLimit) {
    EXPECT_EQ(reduction_to_width(1920, 2800), 1);
    EXPECT_EQ(reduction_to_width(2800, 2800), 1);
    EXPECT_EQ(reduction_to_width(2801, 2800), 2);
    EXPECT_EQ(reduction_to_width(6000, 2800), 3);
    EXPECT_EQ(reduction_to_width(6000, 0), 1);
}

// A reconstruction that takes its stages from the cache reads images of the same size.
TEST_F(SoftImagesTest, WideImagesAreReconstructedAtHalfTheirSize) {
    const auto run = [&](const std::string& name) {
        return reconstruct_dive({.dive = *folder_ / "dive",
                                 .out = *folder_ / name,
                                 .scratch = *folder_ / (name + "-scratch"),
                                 .cache = *folder_ / "cache",
                                 .cache_bytes = std::int64_t{1} << 30,
                                 .options = make_options("standard", {{"max_width_px", 160}})},
                                base::ignore_progress);
    };
    const auto content = [&](const std::string& name) {
        std::ifstream stream(*folder_ / name / "mesh.ply", std::ios::binary);
        return std::string{std::istreambuf_iterator<char>(stream), {}};
    };
    for (const std::string name : {"wide", "again"}) {
        const nlohmann::json metrics = run(name);
        EXPECT_EQ(metrics["frames"]["reduction"], 2);
        EXPECT_EQ(metrics["speed"]["stages"][1]["reused"], name == "again");
        EXPECT_TRUE(std::ranges::any_of(metrics["findings"], [](const nlohmann::json& finding) {
            return finding["code"] == "images_reduced";
        }));
        EXPECT_LT(metrics["trajectory"]["final"]["ate_rmse_m"], 0.005);
    }
    EXPECT_GT(content("wide").size(), 10'000U);
    EXPECT_EQ(content("wide"), content("again"));
}

TEST_F(SoftImagesTest, WhatIsLostInReducedImagesIsTrackedInSmallerOnes) {
    SoftRecording soft(*dive_);
    AlignedRecording recording(soft);
    recording.set_reduction(2);
    types::Track lost = tracked(recording);
    lost.reduction = 2;
    lost.motions.assign(lost.motions.size(), types::MotionSource::Nothing);

    EXPECT_EQ(
        better_reduction(lost, options_, *folder_ / "reduced", recording, base::ignore_progress),
        4);
    EXPECT_EQ(recording.reduction(), 2);
}

// The ray of a point is the same in both sizes.
TEST_F(SoftImagesTest, TheReducedRigSeesPointsInTheReducedPixels) {
    SoftRecording soft(*dive_);
    AlignedRecording recording(soft);
    recording.set_reduction(2);
    const Eigen::Vector3d p_cam(0.2, -0.1, 1.5);

    const Eigen::Vector2d full = *camera::project(recording.recorded_rig().cam0, p_cam);
    const Eigen::Vector2d reduced = *camera::project(recording.rig().cam0, p_cam);
    const auto frame = recording.frame(0);

    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->left.cols, recording.rig().cam0.width_px);
    EXPECT_EQ(frame->right.rows, recording.rig().cam1.height_px);
    // The centre of reduced pixel 0 is between full pixels 0 and 1.
    EXPECT_NEAR(2.0 * reduced.x() + 0.5, full.x(), 1e-9);
    EXPECT_NEAR(2.0 * reduced.y() + 0.5, full.y(), 1e-9);
}

}  // namespace
}  // namespace divemesh::pipeline
