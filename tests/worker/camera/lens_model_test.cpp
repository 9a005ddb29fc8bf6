#include "worker/camera/lens_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <set>
#include <utility>
#include <vector>

#include "worker/camera/projection.hpp"
#include "worker/camera/rerectifier.hpp"

namespace divemesh::camera {
namespace {

using types::Distortion;

// Returns a camera of each model, with coefficients as calibrations of real lenses have them.
std::vector<types::Camera> cameras() {
    std::vector<types::Camera> all;
    const auto add = [&](Distortion distortion, const types::LensCoefficients& k, double focal_px) {
        all.push_back({640, 480, focal_px, 1.01 * focal_px, 322.5, 236.25, distortion, k});
    };
    add(Distortion::None, {}, 450.0);
    add(Distortion::RadialTangential, {-0.28, 0.07, 2e-4, 2e-5}, 458.0);
    add(Distortion::Equidistant, {-0.013, 0.02, -0.012, 0.002}, 380.0);
    add(Distortion::Rational, {-0.3, 0.11, 2e-4, -3e-4, -0.02}, 460.0);
    add(Distortion::Rational, {0.25, 0.03, 3e-4, -4e-4, 0.002, 0.37, 0.06, 0.003}, 440.0);
    add(Distortion::Omnidirectional, {1.47, -0.2, 0.6, 5e-4, -7e-4}, 300.0);
    add(Distortion::Omnidirectional, {0.8}, 300.0);
    add(Distortion::DoubleSphere, {-0.2, 0.57}, 300.0);
    add(Distortion::DoubleSphere, {0.3, 0.62}, 300.0);
    add(Distortion::ExtendedUnified, {0.61, 1.1}, 300.0);
    return all;
}

std::vector<Eigen::Vector2d> pixels_of(const types::Camera& camera) {
    std::vector<Eigen::Vector2d> pixels;
    for (int v = 0; v < camera.height_px; v += 11)
        for (int u = 0; u < camera.width_px; u += 13) pixels.emplace_back(u, v);
    pixels.emplace_back(camera.width_px - 1, camera.height_px - 1);
    pixels.emplace_back(camera.cx_px, camera.cy_px);
    return pixels;
}

// Returns rays to all sides up to 60 degrees off the axis, of many lengths.
std::vector<Eigen::Vector3d> points() {
    std::vector<Eigen::Vector3d> all;
    for (double angle = 0.0; angle < 1.05; angle += 0.07)
        for (double turn = 0.1; turn < 6.2; turn += 0.5)
            all.push_back((0.3 + turn) * Eigen::Vector3d(std::sin(angle) * std::cos(turn),
                                                         std::sin(angle) * std::sin(turn),
                                                         std::cos(angle)));
    return all;
}

// Returns where a pinhole camera of OpenCV sees points, with its distortion.
Eigen::Vector2d by_opencv(const Eigen::Vector3d& p,
                          const Eigen::Vector2d& focal_px,
                          const types::Camera& camera,
                          const std::vector<double>& k) {
    const cv::Mat matrix = (cv::Mat_<double>(3, 3) << focal_px.x(),
                            0,
                            camera.cx_px,
                            0,
                            focal_px.y(),
                            camera.cy_px,
                            0,
                            0,
                            1);
    const std::vector<cv::Point3d> object = {{p.x(), p.y(), p.z()}};
    std::vector<cv::Point2d> image;
    cv::projectPoints(object, cv::Vec3d(), cv::Vec3d(), matrix, k, image);
    return {image[0].x, image[0].y};
}

TEST(LensModelTest, EveryModelHasANameAndKnowsItself) {
    std::set<std::string_view> names;
    for (const LensModel& model : lens_models()) {
        EXPECT_TRUE(names.insert(model.name).second) << model.name;
        EXPECT_EQ(&lens_model(model.distortion), &model);
        EXPECT_LE(model.num_coefficients, types::LensCoefficients().size());
    }
    EXPECT_EQ(names.size(), 7U);
}

TEST(LensModelTest, EveryPixelOfTheImageComesBackFromItsRay) {
    for (const types::Camera& camera : cameras()) {
        double max_px = 0.0;
        for (const Eigen::Vector2d& pixel : pixels_of(camera)) {
            const auto back = project(camera, unproject(camera, pixel));
            ASSERT_TRUE(back);
            max_px = std::max(max_px, (*back - pixel).norm());
        }
        EXPECT_LT(max_px, 1e-9) << lens_model(camera.distortion).name;
    }
}

// fx_px and fy_px are pixels per radian on the axis, of any model.
TEST(LensModelTest, FocalLengthsAreThoseOnTheAxis) {
    for (const types::Camera& camera : cameras()) {
        const Eigen::Vector2d centre = *project(camera, Eigen::Vector3d::UnitZ());
        const Eigen::Vector2d right = *project(camera, {1e-6, 0.0, 1.0});
        const Eigen::Vector2d below = *project(camera, {0.0, 1e-6, 1.0});
        EXPECT_NEAR((right - centre).x() * 1e6, camera.fx_px, 0.01);
        EXPECT_NEAR((below - centre).y() * 1e6, camera.fy_px, 0.01);
    }
}

TEST(LensModelTest, FiveAndEightCoefficientsAreThoseOfOpenCv) {
    for (const types::Camera& camera : cameras()) {
        if (lens_model(camera.distortion).is_fisheye) continue;
        const auto& k = camera.distortion_coefficients;
        for (const Eigen::Vector3d& p : points()) {
            if (p.head<2>().norm() > 0.85 * p.z()) continue;  // the polynomials turn back there
            const Eigen::Vector2d expected =
                by_opencv(p, {camera.fx_px, camera.fy_px}, camera, {k.begin(), k.end()});
            EXPECT_LT((*project(camera, p) - expected).norm(), 1e-9);
        }
    }
}

// Onto the unit sphere, seen from xi behind its centre by a pinhole camera with OpenCV's
// distortion.
TEST(LensModelTest, OmnidirectionalIsAPinholeBehindTheCentreOfASphere) {
    for (const types::Camera& camera : cameras()) {
        if (camera.distortion != Distortion::Omnidirectional) continue;
        const auto& k = camera.distortion_coefficients;
        const Eigen::Vector2d focal_px = (1.0 + k[0]) * Eigen::Vector2d(camera.fx_px, camera.fy_px);
        for (const Eigen::Vector3d& p : points()) {
            const Eigen::Vector3d seen = p.normalized() + Eigen::Vector3d(0.0, 0.0, k[0]);
            const Eigen::Vector2d expected =
                by_opencv(seen, focal_px, camera, {k[1], k[2], k[3], k[4]});
            EXPECT_LT((*project(camera, p) - expected).norm(), 1e-9);
        }
    }
}

// Onto a first unit sphere, from xi behind its centre onto a second one, and from alpha / (1 -
// alpha) behind that by a pinhole camera.
TEST(LensModelTest, DoubleSphereGoesOverTwoSpheres) {
    for (const types::Camera& camera : cameras()) {
        if (camera.distortion != Distortion::DoubleSphere) continue;
        const double xi = camera.distortion_coefficients[0];
        const double alpha = camera.distortion_coefficients[1];
        const double behind = alpha / (1.0 - alpha);
        // On the axis the second sphere is hit at z = 1.
        const Eigen::Vector2d focal_px =
            (1.0 + xi) * (1.0 + behind) * Eigen::Vector2d(camera.fx_px, camera.fy_px);
        for (const Eigen::Vector3d& p : points()) {
            const Eigen::Vector3d second =
                (p.normalized() + Eigen::Vector3d(0.0, 0.0, xi)).normalized();
            const Eigen::Vector2d m = second.head<2>() / (second.z() + behind);
            const Eigen::Vector2d expected =
                focal_px.cwiseProduct(m) + Eigen::Vector2d(camera.cx_px, camera.cy_px);
            EXPECT_LT((*project(camera, p) - expected).norm(), 1e-9);
        }
    }
}

// Onto the ellipsoid beta (x^2 + y^2) + z^2 = 1, found by bisection along the ray, and from alpha /
// (1 - alpha) behind its centre by a pinhole camera.
TEST(LensModelTest, ExtendedUnifiedGoesOverAnEllipsoid) {
    for (const types::Camera& camera : cameras()) {
        if (camera.distortion != Distortion::ExtendedUnified) continue;
        const double alpha = camera.distortion_coefficients[0];
        const double beta = camera.distortion_coefficients[1];
        const double behind = alpha / (1.0 - alpha);
        for (const Eigen::Vector3d& p : points()) {
            double inside = 0.0;
            double outside = 100.0;
            for (int i = 0; i < 100; ++i) {
                const double scale = 0.5 * (inside + outside);
                const Eigen::Vector3d at = scale * p;
                const bool is_out = beta * at.head<2>().squaredNorm() + at.z() * at.z() > 1.0;
                (is_out ? outside : inside) = scale;
            }
            const Eigen::Vector3d on = inside * p;
            const Eigen::Vector2d m = (1.0 + behind) * on.head<2>() / (on.z() + behind);
            const Eigen::Vector2d expected(camera.fx_px * m.x() + camera.cx_px,
                                           camera.fy_px * m.y() + camera.cy_px);
            EXPECT_LT((*project(camera, p) - expected).norm(), 1e-9);
        }
    }
}

// A pixel far outside what the lens sees has a ray within 85 degrees, to the same side.
TEST(LensModelTest, RaysOfFisheyesEndAt85Degrees) {
    auto all = cameras();
    for (const auto& [distortion, k] :
         {std::pair(Distortion::DoubleSphere, types::LensCoefficients{0.0, 1.0}),
          std::pair(Distortion::DoubleSphere, types::LensCoefficients{-0.9, 1.0}),
          std::pair(Distortion::DoubleSphere, types::LensCoefficients{1.0, 0.0}),
          std::pair(Distortion::ExtendedUnified, types::LensCoefficients{1.0, 1.0}),
          std::pair(Distortion::ExtendedUnified, types::LensCoefficients{0.0, 1e-3}),
          std::pair(Distortion::Omnidirectional, types::LensCoefficients{20.0}),
          std::pair(Distortion::Omnidirectional, types::LensCoefficients{-0.9})})
        all.push_back({640, 480, 300.0, 300.0, 320.0, 240.0, distortion, k});
    for (const types::Camera& camera : all) {
        if (!lens_model(camera.distortion).is_fisheye) continue;
        for (const double beside_px : {0.0, 299.0, 300.0, 301.0, 600.0, 1e5, 1e9}) {
            const Eigen::Vector3d ray = unproject(camera, {camera.cx_px + beside_px, camera.cy_px});
            EXPECT_LE(std::atan(ray.head<2>().norm()), kMaxFisheyeAngle_rad + 1e-9);
            EXPECT_GE(ray.x(), 0.0);
            EXPECT_TRUE(ray.allFinite());
        }
    }
}

// The refinement of lenses sees a change of any model as the images do.
TEST(LensModelTest, AChangedLensMovesRaysAsItsDerivativesSay) {
    for (const types::Camera& camera : cameras()) {
        types::Rig rig;
        rig.cam0 = rig.cam1 = camera;
        rig.T_imu_cam1.translation() = Eigen::Vector3d(0.1, 0.0, 0.0);
        types::RectifiedRig rectified;
        rectified.width_px = 640;
        rectified.height_px = 480;
        rectified.focal_px = 400.0;
        rectified.cx_px = 319.5;
        rectified.cy_px = 239.5;
        std::array<types::LensChange, 2> change;
        change[0].values << 2e-4, 0.1, -0.08, 2e-4, -1e-4;
        const Rerectifier rerectifier(rig, rectified, change);
        const auto lenses = rectified_lenses(rig);
        for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(60, 50), Eigen::Vector2d(500, 400)}) {
            const Eigen::Vector2d moved = rerectifier.back(0, pixel) - pixel;
            const Eigen::Vector2d by_derivatives =
                shift_of_change(rectified, lenses[0], pixel) * change[0].values;
            EXPECT_LT((moved - by_derivatives).norm(), 0.01 * moved.norm() + 1e-4)
                << lens_model(camera.distortion).name;
        }
    }
}

}  // namespace
}  // namespace divemesh::camera
