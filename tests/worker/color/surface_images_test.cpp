#include "worker/color/surface_images.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "tests/worker/color/water_world.hpp"
#include "tests/worker/texture/square_mesh.hpp"
#include "worker/color/restored_images.hpp"

namespace divemesh::color {
namespace {

const types::RectifiedRig kRig{.width_px = 161,
                               .height_px = 121,
                               .focal_px = 125.0,
                               .cx_px = 80.0,
                               .cy_px = 60.0,
                               .baseline_m = 0.1};
constexpr std::array<double, 3> kSand = {0.5, 0.45, 0.35};
constexpr double kHeight_m = 1.2;  // of the camera over sand
constexpr float kStep_m = 0.45F;   // of a ledge over sand, at x < 0

// Sand with a ledge, before a camera with lamps that looks straight down; as it is level, depth is
// that of one or the other.
class Ledge {
public:
    types::Mesh mesh = texture::square_mesh(6.0F, 120);
    std::vector<types::Keyframe> keyframes{{.frame_index = 3}};
    ColorFit fit;

    Ledge() {
        texture::add_square(mesh, {-1.5F, 0.0F, kStep_m}, 3.0F, 60);
        keyframes[0].T_world_cam.linear() =
            Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()).toRotationMatrix();
        keyframes[0].T_world_cam.translation() = Eigen::Vector3d(0.013, 0.011, kHeight_m);
        fit.outcome = FitOutcome::Estimated;
        fit.light = LightSource::Camera;
        fit.channels = green_water();
        fit.near_m = 0.5;
        fit.far_m = 4.0;
        fit.log_gains = {0.0};
    }

    double depth_m(int u) const {
        const double ledge_m = kHeight_m - static_cast<double>(kStep_m);
        const double x = kRig.point_cam(u, 0, ledge_m).x() + keyframes[0].T_world_cam(0, 3);
        return x < 0.0 ? ledge_m : kHeight_m;
    }
    bool is_beside_step(int u) const { return depth_m(u - 2) != depth_m(u + 2); }
    cv::Mat image() const {
        cv::Mat image(kRig.height_px, kRig.width_px, CV_8UC3);
        for (int v = 0; v < image.rows; ++v)
            for (int u = 0; u < image.cols; ++u) {
                const double range_m = kRig.point_cam(u, v, depth_m(u)).norm();
                for (std::size_t c = 0; c < 3; ++c) {
                    const double direct =
                        direct_of(fit.channels[c], fit.light, range_m, depth_m(u) / range_m);
                    image.at<cv::Vec3b>(v, u)[static_cast<int>(2 - c)] =
                        level_of(static_cast<float>(kSand[c] * direct +
                                                    backscatter(fit.channels[c], range_m)));
                }
            }
        return image;
    }
};

TEST(SurfaceImages, HaveRangeAndCosineUpToAStepInDepth) {
    const Ledge ledge;
    const SurfaceImages images(SeenSurface(ledge.mesh, kRig), ledge.keyframes[0]);
    for (int v = 0; v < kRig.height_px; v += 3)
        for (int u = 2; u + 2 < kRig.width_px; ++u) {
            const double range_m = kRig.point_cam(u, v, ledge.depth_m(u)).norm();
            const SurfaceImages::Pixel pixel = images.at(v, u);
            EXPECT_NEAR(pixel.cosine, ledge.depth_m(u) / range_m, 0.03);
            if (ledge.is_beside_step(u)) continue;
            EXPECT_NEAR(pixel.range_m, range_m, 0.003);
        }
}

TEST(SurfaceImages, HaveNoRangeWithoutSurface) {
    const types::Mesh nothing;
    const SurfaceImages images(SeenSurface(nothing, kRig), Ledge().keyframes[0]);
    EXPECT_EQ(images.at(5, 7).range_m, 0.0F);
    EXPECT_EQ(images.at(5, 7).cosine, 1.0F);
}

// A cosine across the step would brighten its rim, as lamps light it by the cosine.
TEST(RestoredImages, HaveNoRimAtAStepInDepth) {
    const Ledge ledge;
    const auto read = restored_images(
        ledge.mesh,
        kRig,
        ledge.keyframes,
        [&ledge](int) { return ledge.image(); },
        Restorer(ledge.fit, {}));
    const cv::Mat restored = read(3);
    for (int v = 0; v < kRig.height_px; v += 3)
        for (int u = 2; u + 2 < kRig.width_px; ++u) {
            if (ledge.is_beside_step(u)) continue;
            for (std::size_t c = 0; c < 3; ++c)
                EXPECT_NEAR(restored.at<cv::Vec3b>(v, u)[static_cast<int>(2 - c)],
                            level_of(static_cast<float>(kSand[c])),
                            6)
                    << u << " " << v;
        }
}

}  // namespace
}  // namespace divemesh::color
