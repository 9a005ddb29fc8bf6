#include "worker/camera/undescribed_port.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/synthetic/ideal_rig.hpp"
#include "tests/synthetic/stereo_world.hpp"
#include "worker/camera/refraction.hpp"

namespace divemesh::camera {
namespace {

// Two pixels of a ray through flat glass: of a calibration in water that holds at a long range, and
// of a pinhole at the place where rays near the axis meet. Snell's law gives both.
struct Pixels {
    Eigen::Vector2d measured_px;
    Eigen::Vector2d ideal_px;
};

Pixels behind_glass(const types::RectifiedRig& rig,
                    const types::Port& port,
                    const Eigen::Vector3d& direction,
                    double depth_m) {
    const base::Ray ray = *ray_in_water(port, direction);
    const Eigen::Vector3d p =
        ray.origin + (depth_m - ray.origin.z()) / ray.direction.z() * ray.direction;
    return {rig.pixel(ray.direction), rig.pixel(p)};
}

TEST(UndescribedPortTest, IsWhatSnellsLawLeavesAtARange) {
    const types::RectifiedRig rig = synthetic::rig();
    const RectifiedLens lens = rectified_lenses(synthetic::ideal_cameras(rig))[0];
    types::Port port{.distance_m = 0.03, .thickness_m = 1e-9, .water_index = 1.337};
    port.p_lens_cam.z() = port.distance_m * (port.water_index - 1.0);
    for (const double depth_m : {0.5, 1.0, 3.0})
        for (const double x : {-0.7, -0.2, 0.4, 0.9})
            for (const double y : {-0.5, 0.0, 0.6}) {
                const Pixels at = behind_glass(rig, port, {x, y, 1.0}, depth_m);
                const Eigen::Vector2d expected = at.ideal_px - at.measured_px;
                const Eigen::Vector2d shift =
                    port.distance_m * shift_of_port(rig, lens, at.measured_px, depth_m);
                EXPECT_LT((shift - expected).norm(), 0.01 * expected.norm() + 1e-6)
                    << x << " " << y << " at " << depth_m << " m";
                EXPECT_GT(shift.dot(at.measured_px - Eigen::Vector2d(rig.cx_px, rig.cy_px)), 0.0);
            }
}

TEST(UndescribedPortTest, WhatGrazesTheGlassIsLeftAlone) {
    const types::RectifiedRig rig = synthetic::rig();
    const RectifiedLens lens = rectified_lenses(synthetic::ideal_cameras(rig))[0];
    const Eigen::Vector2d far_out = rig.pixel({1.2, 0.0, 1.0});  // 50 degrees in water
    EXPECT_EQ(shift_of_port(rig, lens, far_out, 1.0), Eigen::Vector2d::Zero());
}

}  // namespace
}  // namespace divemesh::camera
