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

Eigen::Isometry3d moved(double x_m, double z_m = 0.0) {
    Eigen::Isometry3d T_other_cam = Eigen::Isometry3d::Identity();
    T_other_cam.translation() = Eigen::Vector3d(-x_m, 0.0, -z_m);
    return T_other_cam;
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
    const std::vector motions{moved(1.0)};
    mark_unshared(motions, view);
    const double disparity_px = view.rig().focal_px * view.rig().baseline_m / 2.0;
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
    const std::vector motions{moved(1.0), moved(-1.0)};
    mark_unshared(motions, view);
    for (int u = 10; u < view.rig().width_px - 10; ++u)
        EXPECT_FALSE(is_unshared(view.pixel(u, 90))) << u;
}

TEST(UnsharedDepth, IsWhatLiesBehindTheOtherCamera) {
    DepthView view = wall_view();
    const std::vector motions{moved(0.0, 2.5)};
    mark_unshared(motions, view);
    EXPECT_TRUE(is_unshared(view.pixel(120, 90)));
}

}  // namespace
}  // namespace divemesh::fusion
