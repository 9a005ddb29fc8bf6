#include "worker/features/surface_slope.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/synthetic/sea_floor.hpp"
#include "worker/features/match_sparse_stereo.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::features {
namespace {

using synthetic::SeaFloor;

cv::Mat look(const Eigen::Isometry3d& T_world_cam) {
    cv::Mat gray;
    cv::extractChannel(SeaFloor().look(T_world_cam).left_color, gray, 0);
    return gray;
}

double disparity_px(const Eigen::Isometry3d& T_world_cam, double u_px, double v_px) {
    return synthetic::small_rig().disparity_px(SeaFloor::seen_at(T_world_cam, u_px, v_px).z());
}

TEST(SurfaceSlopeTest, AFloorSeenAtAnAngleLeansInTheDisparities) {
    const types::RectifiedRig rig = synthetic::small_rig();
    Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
    T_world_cam.rotate(Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitX()) *
                       Eigen::AngleAxisd(-0.3, Eigen::Vector3d::UnitY()));
    types::RectifiedFrame frame;
    frame.left = look(T_world_cam);
    frame.right = look(T_world_cam * Eigen::Translation3d(rig.baseline_m, 0.0, 0.0));
    types::Features features;
    for (int i = 0; i < 60; ++i)
        features.push_back({i, {70.0 + 22.0 * (i % 10), 40.0 + 30.0 * (i / 10)}, 0.0});
    match_sparse_stereo(frame, {}, 64, features);

    measure_slopes(rig, frame, features);

    std::vector<double> errors;
    double leaning = 0.0;
    for (const types::Feature& feature : features) {
        if (!types::has_depth(feature)) continue;
        const double u = feature.pixel.x();
        const double v = feature.pixel.y();
        const Eigen::Vector2d truth(
            0.5 * (disparity_px(T_world_cam, u + 1, v) - disparity_px(T_world_cam, u - 1, v)),
            0.5 * (disparity_px(T_world_cam, u, v + 1) - disparity_px(T_world_cam, u, v - 1)));
        errors.push_back((feature.disparity_slope - truth).norm());
        leaning = std::max(leaning, truth.norm());
    }
    ASSERT_GE(errors.size(), 30U);
    EXPECT_GT(leaning, 0.03);
    EXPECT_LT(stats::upper_median(errors), 0.2 * leaning);
}

TEST(SurfaceSlopeTest, WhereTheRightImageShowsNothingTheSurfaceFacesTheCamera) {
    const types::RectifiedRig rig = synthetic::small_rig();
    types::RectifiedFrame frame;
    frame.left = look(Eigen::Isometry3d::Identity());
    frame.right = cv::Mat(frame.left.size(), CV_8U, cv::Scalar(100));
    types::Features features = {{1, {160.0, 120.0}, 15.0}, {2, {12.0, 120.0}, 15.0}};
    measure_slopes(rig, frame, features);
    ASSERT_EQ(features.size(), 2U);
    for (const types::Feature& feature : features)
        EXPECT_EQ(feature.disparity_slope, Eigen::Vector2d(0.0, 0.0));
}

}  // namespace
}  // namespace divemesh::features
