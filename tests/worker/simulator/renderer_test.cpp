#include "worker/simulator/renderer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/core.hpp>

#include "worker/camera/projection.hpp"
#include "worker/simulator/draw_rig.hpp"
#include "worker/simulator/fit_ports.hpp"

namespace divemesh::simulator {
namespace {

constexpr int kWidth_px = 80;
constexpr int kHeight_px = 60;

// Returns a pose that looks straight down from 1.5 m, slightly rotated and tilted.
Eigen::Isometry3d look_down() {
    Eigen::Isometry3d T_world_imu = Eigen::Isometry3d::Identity();
    T_world_imu.translation() = Eigen::Vector3d(0.05, -0.1, 1.5);
    T_world_imu.linear() = (Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()) *
                            Eigen::AngleAxisd(1.45, Eigen::Vector3d::UnitY()) *
                            Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitX()))
                               .toRotationMatrix();
    return T_world_imu;
}

Scene make_floor_with_box(float box_height_m) {
    SceneBuilder builder(1, 1, place_at({0, 0, 0}));
    builder.add("floor",
                Material::Sand,
                make_height_field({-4, 4, -4, 4}, 0.1F, [](float, float) { return 0.0F; }),
                place_at({0, 0, 0}));
    if (box_height_m > 0.0F)
        builder.add("box",
                    Material::Wood,
                    make_box({0.5F, 0.4F, 2.0F * box_height_m}, 0.05F),
                    place_at({0, 0, 0}));
    return builder.finish({}, 0.0);
}

// Returns the distance along the ray to the plane z = 0 or to the box on it, by slabs.
double analytic_t(const Eigen::Vector3d& origin,
                  const Eigen::Vector3d& direction,
                  double box_height_m) {
    const double floor_t = -origin.z() / direction.z();
    const Eigen::Array3d half(0.25, 0.2, box_height_m);
    const Eigen::Array3d a = (-half - origin.array()) / direction.array();
    const Eigen::Array3d b = (half - origin.array()) / direction.array();
    const double enter = a.min(b).maxCoeff();
    const double leave = a.max(b).minCoeff();
    return box_height_m > 0.0 && enter < leave ? std::min(enter, floor_t) : floor_t;
}

void expect_analytic_depth(double box_height_m) {
    const Scene scene = make_floor_with_box(static_cast<float>(box_height_m));
    const types::Rig rig = draw_rig(kWidth_px, kHeight_px, 3);
    Renderer renderer(scene, rig, {.water = make_water(WaterKind::None), .exact_depth = true});
    for (const int index : {0, 1}) {
        const Rendering rendering = renderer.render(index, look_down(), 0.0);
        const types::Camera& camera = index == 0 ? rig.cam0 : rig.cam1;
        const Eigen::Isometry3d T_world_cam =
            look_down() * (index == 0 ? rig.T_imu_cam0 : rig.T_imu_cam1);
        int num_wrong = 0;
        for (int v = 0; v < kHeight_px; ++v)
            for (int u = 0; u < kWidth_px; ++u) {
                const Eigen::Vector3d direction =
                    T_world_cam.linear() * camera::unproject(camera, Eigen::Vector2d(u, v));
                const double expected =
                    analytic_t(T_world_cam.translation(), direction, box_height_m);
                if (std::abs(rendering.depth.at<float>(v, u) - expected) > 1e-4) ++num_wrong;
            }
        EXPECT_LE(num_wrong, 2);  // rays that graze an edge
    }
}

TEST(RendererTest, DepthOfAPlaneIsTheAnalyticIntersection) { expect_analytic_depth(0.0); }

TEST(RendererTest, DepthOfABoxIsTheAnalyticIntersection) { expect_analytic_depth(0.3); }

// Behind a port the depth of a pixel leads along its refracted ray to the plane, and the point
// there is seen at that pixel.
TEST(RendererTest, DepthThroughAPortLeadsToThePointThatThePixelShows) {
    const Scene scene = make_floor_with_box(0.0F);
    for (const auto shape : {types::Port::Shape::Flat, types::Port::Shape::Dome}) {
        const types::Rig rig = fit_ports(draw_rig(kWidth_px, kHeight_px, 3),
                                         {.ports = SimulatedPorts{.shape = shape}});
        Renderer renderer(scene, rig, {.water = make_water(WaterKind::Green), .exact_depth = true});
        const Rendering rendering = renderer.render(0, look_down(), 0.0);
        const Eigen::Isometry3d T_world_cam = look_down() * rig.T_imu_cam0;
        for (int v = 0; v < kHeight_px; v += 7)
            for (int u = 0; u < kWidth_px; u += 7) {
                const base::Ray ray = camera::sight_ray(rig.cam0, Eigen::Vector2d(u, v));
                const double depth_m = rendering.depth.at<float>(v, u);
                const Eigen::Vector3d p_cam =
                    ray.origin + (depth_m - ray.origin.z()) * ray.direction;
                EXPECT_NEAR((T_world_cam * p_cam).z(), 0.0, 1e-5);
                const auto pixel = camera::project(rig.cam0, p_cam);
                ASSERT_TRUE(pixel);
                EXPECT_LT((*pixel - Eigen::Vector2d(u, v)).norm(), 1e-6);
            }
    }
}

TEST(RendererTest, FishIsWhereItSwimsInBothCameras) {
    const Scene scene = make_floor_with_box(0.0F);
    const types::Rig rig = draw_rig(kWidth_px, kHeight_px, 3);
    SurveyPath path;
    path.center_world.z() = 1.5;
    path.look_pitch = 1.4;
    const auto motion = DiverMotion::open_path(path, 2.0, 2);
    const auto school =
        Fish::make_school(motion, motion.duration_s(), rig.T_imu_cam0.linear().col(2), 1.0, 2);
    Renderer renderer(scene, rig, {.water = make_water(WaterKind::Green), .fish = school});
    int num_seen = 0;
    for (double t_s = 0.0; t_s < motion.duration_s(); t_s += 0.5) {
        const Eigen::Isometry3d T_world_imu = motion.at(t_s).T_world_imu;
        for (const int index : {0, 1}) {
            const Rendering rendering = renderer.render(index, T_world_imu, t_s);
            const types::Camera& camera = index == 0 ? rig.cam0 : rig.cam1;
            const Eigen::Isometry3d T_world_cam =
                T_world_imu * (index == 0 ? rig.T_imu_cam0 : rig.T_imu_cam1);
            for (const Fish& fish : school) {
                const Eigen::Vector3d p_world = fish.at(t_s).center_world.cast<double>();
                const auto pixel = camera::project(camera, T_world_cam.inverse() * p_world);
                if (!pixel || !camera::contains(camera, *pixel) || p_world.z() < 0.1) continue;
                if ((T_world_cam.inverse() * p_world).z() < 0.5) continue;
                ++num_seen;
                EXPECT_EQ(
                    rendering.fish.at<std::uint8_t>(static_cast<int>(std::lround(pixel->y())),
                                                    static_cast<int>(std::lround(pixel->x()))),
                    255);
            }
        }
    }
    EXPECT_GT(num_seen, 4);
}

TEST(RendererTest, SnowIsLeftOutBehindTheSceneAndMarkedInItsMask) {
    const types::Rig rig = draw_rig(kWidth_px, kHeight_px, 3);
    const MarineSnow snow(3000.0, 5);
    const auto draw = [&](float wall_m) {
        Rendering rendering;
        rendering.radiance = cv::Mat(kHeight_px, kWidth_px, CV_32FC3, cv::Scalar::all(0));
        rendering.depth = cv::Mat(kHeight_px, kWidth_px, CV_32F, cv::Scalar(wall_m));
        rendering.snow = cv::Mat::zeros(kHeight_px, kWidth_px, CV_8U);
        const Water water = make_water(WaterKind::Green);
        snow.draw(rig.cam0, rig.T_imu_cam0, 1.0, water, rendering);
        return std::pair(cv::countNonZero(rendering.snow), cv::sum(rendering.radiance)[1]);
    };
    const auto [covered, light] = draw(5.0F);
    EXPECT_GT(covered, 10);
    EXPECT_GT(light, 0.5);
    EXPECT_EQ(draw(0.1F).first, 0);
}

}  // namespace
}  // namespace divemesh::simulator
