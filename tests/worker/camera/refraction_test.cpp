#include "worker/camera/refraction.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "worker/camera/projection.hpp"

namespace divemesh::camera {
namespace {

using types::Port;

Port flat_port() {
    return {.distance_m = 0.025, .thickness_m = 0.006, .glass_index = 1.49, .water_index = 1.34};
}

Port tilted_port() {
    Port port = flat_port();
    port.normal = Eigen::Vector3d(0.04, -0.03, 1.0).normalized();
    port.p_lens_cam = {0.001, -0.002, -0.01};
    return port;
}

Port dome_port() {
    return {.shape = Port::Shape::Dome,
            .centre_m = {0.001, -0.0015, -0.006},
            .radius_m = 0.05,
            .thickness_m = 0.004,
            .glass_index = 1.49,
            .water_index = 1.34};
}

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

TEST(RefractionTest, AFlatPortBendsByTheSinesAndShiftsByTheTangents) {
    const double air = 0.5;  // rad off the normal
    const double glass = std::asin(std::sin(air) / 1.49);
    const double water = std::asin(std::sin(air) / 1.34);

    const auto ray = ray_in_water(flat_port(), {std::sin(air), 0.0, std::cos(air)});

    ASSERT_TRUE(ray);
    EXPECT_LT((ray->direction - Eigen::Vector3d(std::sin(water), 0.0, std::cos(water))).norm(),
              1e-12);
    EXPECT_NEAR(ray->origin.x(), 0.025 * std::tan(air) + 0.006 * std::tan(glass), 1e-12);
    EXPECT_NEAR(ray->origin.z(), 0.031, 1e-12);
}

TEST(RefractionTest, ADomeWithTheLensAtItsCentreBendsNothing) {
    Port port = dome_port();
    port.centre_m.setZero();
    const Eigen::Vector3d direction(0.4, -0.3, 1.0);

    const auto ray = ray_in_water(port, direction);

    ASSERT_TRUE(ray);
    EXPECT_LT((ray->direction - direction.normalized()).norm(), 1e-12);
    EXPECT_LT((ray->origin - 0.054 * direction.normalized()).norm(), 1e-12);
}

// Paraxial optics by hand: at a face n' u' = n u - y (n' - n) / R, with R < 0 as the centre lies
// before the face.
TEST(RefractionTest, ADomeBeforeALensOffItsCentreFollowsParaxialOptics) {
    Port port = dome_port();
    port.centre_m = {0.0, 0.0, -0.01};
    const double u = 1e-4;       // rad, in air
    const double y1 = 0.04 * u;  // at the inner face, 5 cm from the centre
    const double glass = (u + y1 * 0.49 / 0.05) / 1.49;
    const double y2 = y1 + 0.004 * glass;
    const double water = (1.49 * glass + y2 * (1.34 - 1.49) / 0.054) / 1.34;

    const auto ray = ray_in_water(port, {u, 0.0, 1.0});

    ASSERT_TRUE(ray);
    EXPECT_NEAR(ray->direction.x() / ray->direction.z() / water, 1.0, 1e-6);
    EXPECT_NEAR(ray->origin.x() / y2, 1.0, 1e-6);
}

TEST(RefractionTest, APointIsSeenByTheRayThatPassesThroughIt) {
    for (const Port& port : {flat_port(), tilted_port(), dome_port()})
        for (const double depth_m : {0.3, 1.0, 5.0})
            for (double x = -0.7; x < 0.8; x += 0.35)
                for (double y = -0.5; y < 0.6; y += 0.25) {
                    const Eigen::Vector3d p_cam = depth_m * Eigen::Vector3d(x, y, 1.0);

                    const auto direction = direction_to(port, p_cam);

                    ASSERT_TRUE(direction);
                    const auto ray = ray_in_water(port, *direction);
                    ASSERT_TRUE(ray);
                    EXPECT_LT((p_cam - ray->origin).cross(ray->direction).norm(), 1e-9 * depth_m);
                }
}

TEST(RefractionTest, APortThatTheRayDoesNotReachShowsNothing) {
    Port port = flat_port();
    port.normal = Eigen::Vector3d::UnitX();
    EXPECT_FALSE(ray_in_water(port, {-0.1, 0.0, 1.0}));
    EXPECT_FALSE(direction_to(flat_port(), {0.0, 0.0, -1.0}));
}

TEST(RefractionTest, PixelsOfACameraBehindAPortProjectBackOnThemselves) {
    for (const Port& port : {flat_port(), tilted_port(), dome_port()}) {
        const types::Camera camera = camera_behind(port);
        for (double u = 0.0; u < 640.0; u += 71.0)
            for (double v = 0.0; v < 480.0; v += 53.0) {
                const base::Ray ray = sight_ray(camera, {u, v});
                for (const double way_m : {0.2, 1.5, 6.0}) {
                    const auto pixel = project(camera, ray.origin + way_m * ray.direction);
                    ASSERT_TRUE(pixel);
                    EXPECT_LT((*pixel - Eigen::Vector2d(u, v)).norm(), 1e-6);
                }
            }
    }
}

TEST(RefractionTest, AFlatPortEnlargesByTheIndexOfTheWater) {
    EXPECT_NEAR(axial_magnification(camera_behind(dome_port())), 1.0, 0.1);
    EXPECT_EQ(axial_magnification({.refractive_index = 1.3}), 1.3);
    Port port = flat_port();
    port.distance_m = port.thickness_m = 0.0;
    types::Camera camera = camera_behind(port);
    camera.cx_px = 320.0;
    EXPECT_NEAR(axial_magnification(camera), 1.34, 1e-4);
}

}  // namespace
}  // namespace divemesh::camera
