#include "worker/stereo/fill_from_views.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/worker/stereo/wall_views.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::stereo {
namespace {

const cv::Rect kHole(120, 70, 90, 80);

// The wall with a hole in what the pair measured.
struct Scene : WallViews {
    explicit Scene(const Shade& shade) : WallViews(shade) {
        depth.disparity_px = true_disparity_px();
        depth.disparity_px(kHole).setTo(0.0);
        depth.sigma_disparity_px = cv::Mat(240, 320, CV_32F, cv::Scalar(0.15));
    }
    int fill() { return fill_from_views(rig(), left, neighbours, depth); }

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
        const bool is_in_hole = cv::Rect2d(kHole).contains(cv::Point2d(pixel.x(), pixel.y()));
        return is_in_hole ? 0.0 : textured(x_m, y_m);
    });
    scene.fill();
    const cv::Rect beyond_windows(kHole.x + 5, kHole.y + 5, kHole.width - 10, kHole.height - 10);
    EXPECT_EQ(cv::countNonZero(scene.depth.disparity_px(beyond_windows)), 0);
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
