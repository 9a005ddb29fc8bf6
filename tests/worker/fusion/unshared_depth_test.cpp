#include "worker/fusion/unshared_depth.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "tests/worker/fusion/synthetic_views.hpp"

namespace divemesh::fusion {
namespace {

bool is_unshared(const SurfacePixel& pixel) { return (pixel.color & SurfacePixel::kUnshared) != 0; }

// Returns the view of a wall 2 m in front of the camera.
DepthView wall_view() {
    const SceneDistance wall = [](const Eigen::Vector3d& p) { return 2.0 - p.z(); };
    return {small_rig(), render_view(wall, small_rig(), Eigen::Isometry3d::Identity()).images};
}

constexpr double kWall_m = 2.0;
constexpr int kStep_px = 4;

// Returns a frame from another place that measured a wall at a distance of its own, everywhere; 0:
// nothing.
OtherFrame moved(double x_m, double z_m = 0.0, double measured_m = kWall_m) {
    const types::RectifiedRig rig = small_rig();
    OtherFrame other;
    other.T_other_cam = Eigen::Isometry3d::Identity();
    other.T_other_cam.translation() = Eigen::Vector3d(-x_m, 0.0, -z_m);
    const double disparity_px = measured_m > 0.0 ? rig.focal_px * rig.baseline_m / measured_m : 0.0;
    other.disparity_px = cv::Mat((rig.height_px + kStep_px - 1) / kStep_px,
                                 (rig.width_px + kStep_px - 1) / kStep_px,
                                 CV_32F,
                                 cv::Scalar(disparity_px));
    other.step_px = kStep_px;
    return other;
}

TEST(UnsharedDepth, IsAllOfAViewThatHasNoNeighbour) {
    DepthView view = wall_view();
    mark_unshared({}, view);
    for (int u = 0; u < view.rig().width_px; ++u) EXPECT_TRUE(is_unshared(view.pixel(u, 90)));
}

// A camera that is 1 m to the right sees the wall from 1 m f / 2 m = 90 px on, and both its cameras
// from as far as the disparity on; its border has no depth.
TEST(UnsharedDepth, IsWhatACameraBesideDoesNotSee) {
    DepthView view = wall_view();
    const std::vector others{moved(1.0)};
    mark_unshared(others, view);
    const double disparity_px = view.rig().focal_px * view.rig().baseline_m / kWall_m;
    constexpr int kBorder_px = 10;
    for (int u = 10; u < view.rig().width_px - 10; ++u) {
        if (u < 90 + disparity_px) {
            EXPECT_TRUE(is_unshared(view.pixel(u, 90))) << u;
        }
        if (u > 90 + disparity_px + kBorder_px) {
            EXPECT_FALSE(is_unshared(view.pixel(u, 90))) << u;
        }
    }
}

TEST(UnsharedDepth, OneOfSeveralNeighboursIsEnough) {
    DepthView view = wall_view();
    const std::vector others{moved(1.0), moved(-1.0)};
    mark_unshared(others, view);
    for (int u = 10; u < view.rig().width_px - 10; ++u)
        EXPECT_FALSE(is_unshared(view.pixel(u, 90))) << u;
}

TEST(UnsharedDepth, IsWhatLiesBehindTheOtherCamera) {
    DepthView view = wall_view();
    const std::vector others{moved(0.0, 2.5)};
    mark_unshared(others, view);
    EXPECT_TRUE(is_unshared(view.pixel(120, 90)));
}

// From the same place the other frame has all in sight, so only what it measured counts.
TEST(UnsharedDepth, IsWhatTheOtherFrameCouldNotMeasure) {
    DepthView view = wall_view();
    std::vector others{moved(0.0)};
    constexpr int kFirstUnknown_px = 120;
    others[0].disparity_px.colRange(kFirstUnknown_px / kStep_px, others[0].disparity_px.cols) = 0.0;
    mark_unshared(others, view);
    EXPECT_FALSE(is_unshared(view.pixel(kFirstUnknown_px - 2 * kStep_px, 90)));
    EXPECT_TRUE(is_unshared(view.pixel(kFirstUnknown_px + 2 * kStep_px, 90)));
}

TEST(UnsharedDepth, IsNotRefutedByOneDisparityAlone) {
    DepthView view = wall_view();
    std::vector others{moved(0.0, 0.0, 0.0)};
    others[0].disparity_px.at<float>(90 / kStep_px, 120 / kStep_px) = 5.0F;
    mark_unshared(others, view);
    EXPECT_TRUE(is_unshared(view.pixel(120, 90)));
}

TEST(UnsharedDepth, IsWhatSomethingNearHidesFromTheOtherFrame) {
    DepthView view = wall_view();
    const std::vector others{moved(0.0, 0.0, 0.7 * kWall_m)};
    mark_unshared(others, view);
    EXPECT_TRUE(is_unshared(view.pixel(120, 90)));
}

// A frame that saw something farther there looked through the wall.
TEST(UnsharedDepth, IsNotWhatTheOtherFrameLookedThrough) {
    DepthView view = wall_view();
    const std::vector others{moved(0.0, 0.0, 1.5 * kWall_m)};
    mark_unshared(others, view);
    EXPECT_FALSE(is_unshared(view.pixel(120, 90)));
}

// Pixels that are fused as means of 2 x 2 look into the other frame at its own size.
TEST(UnsharedDepth, HoldsAtHalfTheSamplingToo) {
    const SceneDistance wall = [](const Eigen::Vector3d& p) { return kWall_m - p.z(); };
    DepthView view(small_rig(),
                   render_view(wall, small_rig(), Eigen::Isometry3d::Identity()).images,
                   Sampling::Half);
    std::vector others{moved(0.0)};
    others[0].disparity_px.colRange(120 / kStep_px, others[0].disparity_px.cols) = 0.0;
    mark_unshared(others, view);
    EXPECT_FALSE(is_unshared(view.pixel(50, 45)));
    EXPECT_TRUE(is_unshared(view.pixel(70, 45)));
}

}  // namespace
}  // namespace divemesh::fusion
