#include "worker/stereo/fill_from_views.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "tests/worker/stereo/warped_pair.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::stereo {
namespace {

using Shade = std::function<double(double x_m, double y_m)>;

constexpr double kDepth_m = 2.0;
constexpr double kPixels_per_m = 150.0;  // of the texture: about one at each pixel

double textured(double x_m, double y_m) {
    return texture(kPixels_per_m * x_m, kPixels_per_m * y_m);
}

types::RectifiedRig rig() {
    types::RectifiedRig rig;
    rig.width_px = 320;
    rig.height_px = 240;
    rig.focal_px = 300.0;
    rig.cx_px = 161.0;
    rig.cy_px = 118.0;
    rig.baseline_m = 0.1;
    return rig;
}

// A slanted wall, z = 2 + 0.3 x + 0.1 y, seen by cameras beside and above each other.
Eigen::Vector3d on_wall(const Eigen::Isometry3d& T_world_cam, double u_px, double v_px) {
    const Eigen::Vector3d ray = T_world_cam.linear() * rig().point_cam(u_px, v_px, 1.0);
    const Eigen::Vector3d from = T_world_cam.translation();
    const Eigen::Vector3d normal(-0.3, -0.1, 1.0);
    return from + ray * ((kDepth_m - normal.dot(from)) / normal.dot(ray));
}

cv::Mat photograph(const Eigen::Isometry3d& T_world_cam, const Shade& shade, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0.0, 2.0);
    cv::Mat image(240, 320, CV_8U);
    for (int v = 0; v < image.rows; ++v)
        for (int u = 0; u < image.cols; ++u) {
            const Eigen::Vector3d p_world = on_wall(T_world_cam, u, v);
            image.at<std::uint8_t>(v, u) = cv::saturate_cast<std::uint8_t>(
                128.0 + shade(p_world.x(), p_world.y()) + noise(random));
        }
    return image;
}

cv::Mat true_disparity_px() {
    cv::Mat disparity_px(240, 320, CV_32F);
    for (int v = 0; v < 240; ++v)
        for (int u = 0; u < 320; ++u)
            disparity_px.at<float>(v, u) = static_cast<float>(
                rig().disparity_px(on_wall(Eigen::Isometry3d::Identity(), u, v).z()));
    return disparity_px;
}

Eigen::Isometry3d camera(double x_m, double y_m, double yaw_deg) {
    Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
    T_world_cam.translation() = Eigen::Vector3d(x_m, y_m, 0.02);
    T_world_cam.linear() =
        Eigen::AngleAxisd(yaw_deg / 180.0 * M_PI, Eigen::Vector3d::UnitY()).toRotationMatrix();
    return T_world_cam;
}

const cv::Rect kHole(120, 70, 90, 80);

// The wall with a hole in what the pair measured, and four frames around it.
struct Scene {
    explicit Scene(const Shade& shade) {
        left = photograph(Eigen::Isometry3d::Identity(), shade, 1);
        for (const Eigen::Isometry3d& T_world_cam : cameras())
            neighbours.push_back(
                {photograph(T_world_cam, shade, static_cast<unsigned>(neighbours.size()) + 2),
                 T_world_cam.inverse()});
        depth.disparity_px = true_disparity_px();
        depth.disparity_px(kHole).setTo(0.0);
        depth.sigma_disparity_px = cv::Mat(240, 320, CV_32F, cv::Scalar(0.15));
    }
    static std::vector<Eigen::Isometry3d> cameras() {
        return {camera(-0.25, 0.0, -2.0),
                camera(-0.12, 0.05, 1.0),
                camera(0.13, -0.04, 0.5),
                camera(0.26, 0.02, 3.0)};
    }
    int fill() { return fill_from_views(rig(), left, neighbours, depth); }

    cv::Mat left;
    std::vector<NeighbourView> neighbours;
    types::DepthMap depth;
};

TEST(FillFromViews, MeasuresWhatThePairDidNot) {
    Scene scene(textured);
    const int num_filled = scene.fill();
    EXPECT_EQ(num_filled, cv::countNonZero(scene.depth.disparity_px(kHole)));
    EXPECT_GT(num_filled, kHole.area() * 9 / 10);
    const cv::Mat truth_px = true_disparity_px();
    std::vector<double> errors_px, errors_in_sigmas;
    for (int v = kHole.y; v < kHole.br().y; ++v)
        for (int u = kHole.x; u < kHole.br().x; ++u) {
            const float disparity_px = scene.depth.disparity_px.at<float>(v, u);
            if (disparity_px <= 0.0F) continue;
            errors_px.push_back(std::abs(disparity_px - truth_px.at<float>(v, u)));
            errors_in_sigmas.push_back(errors_px.back() /
                                       scene.depth.sigma_disparity_px.at<float>(v, u));
        }
    EXPECT_LT(stats::upper_median(errors_px), 0.1);
    EXPECT_LT(*std::max_element(errors_px.begin(), errors_px.end()), 1.0);
    std::sort(errors_in_sigmas.begin(), errors_in_sigmas.end());
    EXPECT_LT(errors_in_sigmas[errors_in_sigmas.size() * 95 / 100], 2.0);
}

TEST(FillFromViews, LeavesWhatWasMeasured) {
    Scene scene(textured);
    const cv::Mat before_px = scene.depth.disparity_px.clone();
    scene.fill();
    cv::Mat is_changed = scene.depth.disparity_px != before_px;
    is_changed(kHole).setTo(0);
    EXPECT_EQ(cv::countNonZero(is_changed), 0);
}

TEST(FillFromViews, FillsNothingWhereThereIsNoTexture) {
    Scene scene([](double x_m, double y_m) {
        const Eigen::Vector2d pixel = rig().pixel({x_m, y_m, kDepth_m + 0.3 * x_m + 0.1 * y_m});
        const bool is_in_hole = kHole.contains(cv::Point(pixel.x(), pixel.y()));
        return is_in_hole ? 0.0 : textured(x_m, y_m);
    });
    EXPECT_LT(scene.fill(), kHole.area() / 20);  // its rim has texture in the window
}

// What is seen there moves: the frames around show another texture each.
TEST(FillFromViews, FillsNothingWhereTheFramesDisagree) {
    Scene scene(textured);
    double shift_m = 50.0;
    const auto cameras = Scene::cameras();
    for (std::size_t i = 0; i < cameras.size(); ++i, shift_m += 50.0)
        scene.neighbours[i].left = photograph(
            cameras[i],
            [&](double x_m, double y_m) { return textured(x_m + shift_m, y_m); },
            static_cast<unsigned>(i) + 2);
    EXPECT_LT(scene.fill(), kHole.area() / 100);
}

// Of stripes along the motion of the cameras every disparity fits.
TEST(FillFromViews, FillsNothingThatSlidesAlong) {
    Scene scene([](double, double y_m) { return textured(0.0, y_m); });
    for (std::size_t i = 0; i < scene.neighbours.size(); ++i) {
        const Eigen::Isometry3d along = camera(0.1 * (static_cast<double>(i) - 1.6), 0.0, 0.0);
        Eigen::Isometry3d T_world_cam = along;
        T_world_cam.translation().z() = 0.0;
        scene.neighbours[i] = {
            photograph(
                T_world_cam, [](double, double y_m) { return textured(0.0, y_m); }, 9),
            T_world_cam.inverse()};
    }
    EXPECT_LT(scene.fill(), kHole.area() / 20);
}

TEST(FillFromViews, NeedsTwoFrames) {
    Scene scene(textured);
    scene.neighbours.resize(1);
    EXPECT_EQ(scene.fill(), 0);
}

}  // namespace
}  // namespace divemesh::stereo
