#include "worker/camera/projection.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace divemesh::camera {
namespace {

TEST(ProjectionTest, AFlatPortRefractsBySnell) {
    types::Camera camera{640, 480, 400.0, 400.0, 320.0, 240.0, types::Distortion::None, {}};
    camera.refractive_index = 1.337;
    for (const double angle_deg : {0.5, 10.0, 25.0, 40.0}) {
        const double angle = angle_deg * std::numbers::pi / 180.0;
        const Eigen::Vector3d ray(0.6 * std::tan(angle), -0.8 * std::tan(angle), 1.0);
        const double in_air = std::asin(1.337 * std::sin(angle));

        const Eigen::Vector2d pixel = *project(camera, ray);

        EXPECT_NEAR((pixel - Eigen::Vector2d(320.0, 240.0)).norm(), 400.0 * std::tan(in_air), 1e-6);
        EXPECT_LT((unproject(camera, pixel) - ray).norm(), 1e-9);
    }
    // Beyond 48.4 degrees no ray passes the port.
    EXPECT_FALSE(project(camera, {std::tan(0.86), 0.0, 1.0}));
}

TEST(ProjectionTest, FisheyeRaysAreThoseOfTheirPixels) {
    const types::Camera camera{
        640,
        480,
        286.2,
        286.3,
        421.1,
        398.2,
        types::Distortion::Equidistant,
        {-0.0053, 0.0419, -0.0394, 0.0064}};  // as of a tracking camera with a fisheye lens
    for (double angle_deg = 0.0; angle_deg < 85.0; angle_deg += 3.0) {
        const double angle = angle_deg * std::numbers::pi / 180.0;
        const Eigen::Vector3d ray(0.6 * std::sin(angle), -0.8 * std::sin(angle), std::cos(angle));

        const Eigen::Vector3d found = unproject(camera, *project(camera, ray));

        EXPECT_LT((found.normalized() - ray).norm(), 1e-9) << angle_deg << " degrees";
    }
}

// Its polynomial turns back at 48 degrees, beyond the corner of the image.
TEST(ProjectionTest, AFisheyePolynomialMayTurnBackBeyondTheImage) {
    const types::Camera camera{1280,
                               960,
                               900.0,
                               900.0,
                               640.0,
                               480.0,
                               types::Distortion::Equidistant,
                               {0.30, 0.2, 0.5, -1.5}};
    for (const double angle_deg : {1.0, 20.0, 43.5, 47.0}) {
        const double angle = angle_deg * std::numbers::pi / 180.0;
        const Eigen::Vector3d ray(0.8 * std::sin(angle), 0.6 * std::sin(angle), std::cos(angle));
        const Eigen::Vector3d found = unproject(camera, *project(camera, ray));
        EXPECT_LT((found.normalized() - ray).norm(), 1e-9) << angle_deg << " degrees";
    }
}

}  // namespace
}  // namespace divemesh::camera
