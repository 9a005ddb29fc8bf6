#include "worker/pipeline/segments_apart.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/temporary_folder.hpp"
#include "tests/worker/fusion/synthetic_views.hpp"
#include "worker/pipeline/reconstruct.hpp"

namespace divemesh::pipeline {
namespace {

constexpr double kMedianDepth_m = 0.5;  // most of the dive swims close above the ground
constexpr double kWall_m = 2.2;         // more than four times as far, and still fused
constexpr int kNumViews = 4;

// Two segments, each of which sees a wall: the first along x, the second against it.
class TwoWalls : public testing::Test {
protected:
    TwoWalls() {
        const auto ahead = [](const Eigen::Vector3d& p) { return kWall_m - p.x(); };
        const auto behind = [](const Eigen::Vector3d& p) { return kWall_m + p.x(); };
        for (int i = 0; i < 2 * kNumViews; ++i) {
            const std::int32_t segment = i < kNumViews ? 0 : 1;
            const Eigen::Vector3d eye(0.0, 0.05 * (i % kNumViews), 0.0);
            const Eigen::Vector3d to = (segment == 0 ? 1.0 : -1.0) * Eigen::Vector3d::UnitX();
            const auto pose = fusion::look_at(eye, eye + to);
            auto view = segment == 0 ? fusion::render_view(ahead, fusion::small_rig(), pose)
                                     : fusion::render_view(behind, fusion::small_rig(), pose);
            view.keyframe.frame_index = i;
            view.keyframe.segment = segment;
            store_.write(i, view.images.depth);
            images_.push_back(view.images.left_color);
            frames_.push_back(view.keyframe);
        }
    }
    types::Mesh fused(double max_depth_m, const ReconstructionOptions& options) const {
        const FusedMap map =
            fuse({fusion::small_rig(), frames_, kMedianDepth_m, store_, max_depth_m},
                 options,
                 folder_ / "",
                 base::ignore_progress);
        return mesh(*map.volume, options, base::ignore_progress).mesh;
    }

    TemporaryFolder folder_;
    std::vector<cv::Mat> images_;
    keyframes::KeyframeStore store_{folder_ / "keyframes",
                                    [this](int frame_index) { return images_.at(frame_index); }};
    std::vector<types::Keyframe> frames_;
};

TEST_F(TwoWalls, FarBehindNearGroundStayOnTheirOwnSides) {
    const double max_depth_m = set_segments_apart(fusion::small_rig(), kMedianDepth_m, frames_);
    const double second_m = frames_.back().T_world_cam.translation().x();
    ASSERT_GT(second_m - kWall_m, kWall_m) << "the walls passed each other";
    int num_first = 0;
    int num_second = 0;
    for (const Eigen::Vector3f& vertex : fused(max_depth_m, {}).vertices) {
        const double x_m = static_cast<double>(vertex.x());
        const bool of_first = x_m < 0.5 * second_m;
        EXPECT_NEAR(x_m, of_first ? kWall_m : second_m - kWall_m, 0.1);
        ++(of_first ? num_first : num_second);
    }
    EXPECT_GT(num_first, 1000);
    EXPECT_GT(num_second, 1000);
}

TEST_F(TwoWalls, NothingIsFusedFartherThanTheSegmentsAllow) {
    ReconstructionOptions options;
    options.voxel_m = 0.02;
    options.max_depth_m = 50.0;
    const double max_depth_m = set_segments_apart(fusion::small_rig(), kMedianDepth_m, frames_);
    EXPECT_FALSE(fused(max_depth_m, options).triangles.empty());
    EXPECT_TRUE(fused(0.9 * kWall_m, options).triangles.empty());
}

TEST(SegmentsApartTest, TheImagesOfTwoSegmentsSeeNoCommonPlaceWithinThatDepth) {
    std::vector<types::Keyframe> keyframes(3);
    keyframes[2].segment = 1;
    const double max_depth_m = set_segments_apart(fusion::small_rig(), 1.0, keyframes);
    const double apart_m = keyframes[2].T_world_cam.translation().x();
    // The corner of an image of 240 x 180 px at a focal length of 180 px.
    const double corner = std::sqrt(1.0 + std::pow(120.0 / 180.0, 2) + std::pow(90.0 / 180.0, 2));
    EXPECT_NEAR(apart_m, 2.0 * (corner * max_depth_m + 1.0), 1e-9);
    EXPECT_EQ(keyframes[1].T_world_cam.translation().x(), 0.0);
}

TEST(SegmentsApartTest, ASingleSegmentHasNoLimit) {
    std::vector<types::Keyframe> keyframes(3);
    EXPECT_EQ(set_segments_apart(fusion::small_rig(), 1.0, keyframes), 0.0);
}

}  // namespace
}  // namespace divemesh::pipeline
