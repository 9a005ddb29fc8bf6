#include "worker/camera/range_correction.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "worker/base/rotation_vector.hpp"
#include "worker/camera/projection.hpp"
#include "worker/camera/rectifier.hpp"
#include "worker/camera/virtual_camera.hpp"

namespace divemesh::camera {
namespace {

using types::Port;

constexpr double kWater = 1.34;

types::Camera camera_behind(const Port& port) {
    types::Camera camera{640,
                         480,
                         489.6,
                         489.1,
                         320.9,
                         238.8,
                         types::Distortion::RadialTangential,
                         {-0.121, 0.0312, 0.00041, -0.00032}};
    camera.port = port;
    return camera;
}

// Two cameras, whose bodies' frame is that of the left lens, in the water.
types::Rig rig_behind(const Port& left, const Port& right) {
    types::Rig rig;
    rig.cam0 = camera_behind(left);
    rig.cam1 = camera_behind(right);
    rig.T_imu_cam1.linear() = base::rotation_from_vector({0.008, -0.012, 0.005}).toRotationMatrix();
    rig.T_imu_cam1.translation() << 0.12, 0.002, -0.003;
    move_into_water(rig.cam0, rig.T_imu_cam0, kWater);
    move_into_water(rig.cam1, rig.T_imu_cam1, kWater);
    return rig;
}

types::Rig flat_rig() {
    Port left{.distance_m = 0.025, .thickness_m = 0.006};
    Port right = left;
    left.normal = Eigen::Vector3d(0.03, 0.01, 1.0).normalized();
    right.normal = Eigen::Vector3d(-0.02, 0.015, 1.0).normalized();
    right.distance_m = 0.03;
    return rig_behind(left, right);
}

types::Rig dome_rig() {
    const Port dome{.shape = Port::Shape::Dome,
                    .centre_m = {0.001, -0.0015, -0.006},
                    .radius_m = 0.05,
                    .thickness_m = 0.004};
    return rig_behind(dome, dome);
}

// What a rectified pair shows of a point, px, and on which row the right image shows it.
struct Shown {
    Eigen::Vector3d measured_px;
    double right_row_px;
};

Shown shown(const types::Rig& rig, const types::RectifiedRig& ideal, const Eigen::Vector3d& p_cam) {
    const auto lenses = rectified_lenses(rig);
    const Eigen::Vector3d p_imu = ideal.T_imu_cam * p_cam;
    const auto at = [&](std::size_t side) {
        const Eigen::Isometry3d& T_imu_cam = side == 0 ? rig.T_imu_cam0 : rig.T_imu_cam1;
        const auto recorded = project(lenses[side].camera, T_imu_cam.inverse() * p_imu);
        return lenses[side].rectified_px(ideal, recorded.value());
    };
    const Eigen::Vector2d left = at(0);
    const Eigen::Vector2d right = at(1);
    return {{left.x(), left.y(), left.x() - right.x()}, right.y()};
}

// Calls `check` for points all over the left image, at a depth.
template <typename Check>
void for_each_point(const types::RectifiedRig& ideal, double depth_m, const Check& check) {
    for (double u = 40.0; u < ideal.width_px; u += 80.0)
        for (double v = 40.0; v < ideal.height_px; v += 80.0) check(ideal.point_cam(u, v, depth_m));
}

TEST(RangeCorrectionTest, RaysOfBothCamerasMeetInThePoint) {
    for (const types::Rig& rig : {flat_rig(), dome_rig()}) {
        const types::RectifiedRig ideal = rectified_rig(rig);
        for (const double depth_m : {0.5, 1.0, 3.0})
            for_each_point(ideal, depth_m, [&](const Eigen::Vector3d& p_cam) {
                const Eigen::Vector3d p_imu = ideal.T_imu_cam * p_cam;
                std::vector<base::Ray> rays;
                for (const auto& [camera, T_imu_cam] : {std::pair(&rig.cam0, &rig.T_imu_cam0),
                                                        std::pair(&rig.cam1, &rig.T_imu_cam1)}) {
                    const auto pixel = project(*camera, T_imu_cam->inverse() * p_imu);
                    ASSERT_TRUE(pixel);
                    const base::Ray ray = sight_ray(*camera, *pixel);
                    rays.push_back({*T_imu_cam * ray.origin, T_imu_cam->linear() * ray.direction});
                }
                const auto found = base::nearest_to_rays(rays, 1e-9);
                ASSERT_TRUE(found);
                EXPECT_LT((*found - p_imu).norm(), 1e-5 * depth_m);
            });
    }
}

TEST(RangeCorrectionTest, AtTheReferenceDepthThePairIsIdeal) {
    for (const types::Rig& rig : {flat_rig(), dome_rig()}) {
        const types::RectifiedRig ideal = rectified_rig(rig);
        for_each_point(ideal, rig.cam0.port->reference_depth_m, [&](const Eigen::Vector3d& p_cam) {
            const Shown seen = shown(rig, ideal, p_cam);
            const Eigen::Vector2d at = ideal.pixel(p_cam);
            EXPECT_NEAR(seen.measured_px.x(), at.x(), 0.01);
            EXPECT_NEAR(seen.measured_px.y(), at.y(), 0.01);
            EXPECT_NEAR(seen.right_row_px, at.y(), 0.01);
            EXPECT_NEAR(seen.measured_px.z(), ideal.disparity_px(p_cam.z()), 0.01);
        });
    }
}

TEST(RangeCorrectionTest, RowsStayTogetherWhereMatchersLook) {
    const types::Rig rig = flat_rig();
    const types::RectifiedRig ideal = rectified_rig(rig);
    for (const double depth_m : {0.8, 1.0, 3.0})
        for_each_point(ideal, depth_m, [&](const Eigen::Vector3d& p_cam) {
            const Shown seen = shown(rig, ideal, p_cam);
            EXPECT_NEAR(seen.right_row_px, seen.measured_px.y(), 0.4);
        });
}

TEST(RangeCorrectionTest, PutsMeasurementsAtAnyRangeWhereAnIdealPairShowsThem) {
    double largest_shift = 0.0;  // without the correction, share of the depth
    for (const types::Rig& rig : {flat_rig(), dome_rig()}) {
        const Rectifier rectifier(rig);
        const types::RectifiedRig& ideal = rectifier.rig();
        types::RectifiedFrame frame;
        frame.ranges = rectifier.ranges();
        ASSERT_TRUE(frame.ranges);
        for (const double depth_m : {0.5, 0.8, 1.2, 2.0, 3.0, 6.0})
            for_each_point(ideal, depth_m, [&](const Eigen::Vector3d& p_cam) {
                const Eigen::Vector3d seen = shown(rig, ideal, p_cam).measured_px;
                const double disparity_px = frame.disparity_px(seen.head<2>(), seen.z());
                const Eigen::Vector3d moved =
                    at_own_range(*frame.ranges, {seen.x(), seen.y(), disparity_px});
                EXPECT_NEAR(ideal.depth_m(disparity_px) / depth_m, 1.0, 1e-4);
                EXPECT_LT((moved.head<2>() - ideal.pixel(p_cam)).norm(), 0.03);
                EXPECT_NEAR(frame.matched_px(seen.head<2>(), disparity_px), seen.z(), 1e-3);
                largest_shift =
                    std::max(largest_shift, std::abs(ideal.depth_m(seen.z()) / depth_m - 1.0));
            });
    }
    EXPECT_GT(largest_shift, 3e-3);
}

TEST(RangeCorrectionTest, ARigWithoutPortsNeedsNone) {
    types::Rig rig = flat_rig();
    rig.cam0.port.reset();
    rig.cam1.port.reset();
    EXPECT_FALSE(Rectifier(rig).ranges());
}

}  // namespace
}  // namespace divemesh::camera
