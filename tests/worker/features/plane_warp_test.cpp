#include "worker/features/plane_warp.hpp"

#include <gtest/gtest.h>

#include "tests/synthetic/stereo_world.hpp"

namespace divemesh::features {
namespace {

TEST(PlaneWarpTest, IsTheDerivativeOfWherePixelsOfThePlaneGo) {
    const types::RectifiedRig rig = synthetic::rig();
    const Eigen::Vector3d p_from(0.2, -0.1, 1.8);
    const Eigen::Vector3d normal(0.3, -0.5, 1.0);
    const Plane plane = normal / normal.dot(p_from);
    Eigen::Isometry3d T_to_from = Eigen::Isometry3d::Identity();
    T_to_from.translation() << 0.3, -0.1, -0.2;
    T_to_from.linear() = base::rotation_from_vector({0.1, -0.2, 0.3}).toRotationMatrix();
    const auto to = [&](const Eigen::Vector2d& pixel) {
        const Eigen::Vector3d ray = rig.point_cam(pixel.x(), pixel.y(), 1.0);
        return rig.pixel(T_to_from * (ray / plane.dot(ray)));
    };
    Eigen::Matrix2d to_by_from;
    for (int axis = 0; axis < 2; ++axis) {
        const Eigen::Vector2d step = 1e-3 * Eigen::Vector2d::Unit(axis);
        to_by_from.col(axis) = (to(rig.pixel(p_from) + step) - to(rig.pixel(p_from) - step)) / 2e-3;
    }
    const auto warp = plane_warp(rig, p_from, plane, T_to_from);
    ASSERT_TRUE(warp);
    EXPECT_LT((*warp * to_by_from - Eigen::Matrix2d::Identity()).norm(), 2e-3);
}

TEST(PlaneWarpTest, WhatIsStretchedTooFarOrBehindTheCameraHasNone) {
    const types::RectifiedRig rig = synthetic::rig();
    const Eigen::Vector3d p_from(0.0, 0.0, 2.0);
    for (const double ahead_m : {1.5, 2.5}) {
        Eigen::Isometry3d T_to_from = Eigen::Isometry3d::Identity();
        T_to_from.translation().z() = -ahead_m;
        EXPECT_FALSE(plane_warp(rig, p_from, fronto_parallel_plane(p_from), T_to_from));
    }
}

}  // namespace
}  // namespace divemesh::features
