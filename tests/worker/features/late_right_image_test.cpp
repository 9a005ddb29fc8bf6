#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "tests/synthetic/sea_floor.hpp"
#include "worker/camera/synchronise_pair.hpp"
#include "worker/features/match_sparse_stereo.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::features {
namespace {

using synthetic::SeaFloor;

// A pair over a floor that is seen at an angle, whose right image was exposed after the camera had
// moved on.
class LateRightImageTest : public ::testing::Test {
protected:
    LateRightImageTest() {
        T_world_cam_.rotate(Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitX()) *
                            Eigen::AngleAxisd(-0.3, Eigen::Vector3d::UnitY()));
        T_later_now_.rotate(
            Eigen::AngleAxisd(0.008, Eigen::Vector3d(0.5, -0.4, 0.77).normalized()));
        T_later_now_.translation() << -0.012, -0.008, -0.015;
        frame_.left = look(T_world_cam_);
        expose_right(T_later_now_);
    }

    void expose_right(const Eigen::Isometry3d& T_then_now) {
        frame_.right = look(T_world_cam_ * T_then_now.inverse() *
                            Eigen::Translation3d(rig_.baseline_m, 0.0, 0.0));
    }

    static cv::Mat look(const Eigen::Isometry3d& T_world_cam) {
        cv::Mat gray;
        cv::extractChannel(SeaFloor().look(T_world_cam).left_color, gray, 0);
        return gray;
    }
    double true_disparity_px(double u_px, double v_px) const {
        return rig_.disparity_px(SeaFloor::seen_at(T_world_cam_, u_px, v_px).z());
    }
    // `share`: of the motion T_later_now_ lies between the exposures.
    types::RectifiedFrame synchronised(double share = 1.0) const {
        const double compensated_px = true_disparity_px(160.0, 120.0);
        return camera::synchronise_pair(
            frame_, camera::exposure_motion(rig_, T_later_now_, share, compensated_px));
    }
    // Returns the errors of the disparities found at a grid of features.
    std::vector<double> errors_px(const types::RectifiedFrame& frame) const {
        types::Features features;
        for (int i = 0; i < 60; ++i)
            features.push_back({i, {70.0 + 22.0 * (i % 10), 40.0 + 30.0 * (i / 10)}, 0.0});
        match_sparse_stereo(frame, {}, 64, features);
        std::vector<double> errors;
        for (const types::Feature& feature : features)
            if (types::has_depth(feature))
                errors.push_back(std::abs(feature.disparity_px -
                                          true_disparity_px(feature.pixel.x(), feature.pixel.y())));
        return errors;
    }

    const types::RectifiedRig rig_ = synthetic::small_rig();
    Eigen::Isometry3d T_world_cam_ = Eigen::Isometry3d::Identity();
    Eigen::Isometry3d T_later_now_ = Eigen::Isometry3d::Identity();
    types::RectifiedFrame frame_;
};

TEST_F(LateRightImageTest, DisparitiesAreThoseOfTheLeftImagesTime) {
    const std::vector<double> recorded = errors_px(frame_);
    const std::vector<double> compensated = errors_px(synchronised());
    ASSERT_GE(compensated.size(), 40U);
    EXPECT_GT(compensated.size(), recorded.size());
    EXPECT_LT(stats::median(compensated), 0.1);
    const auto num_right = static_cast<std::size_t>(
        std::count_if(recorded.begin(), recorded.end(), [](double error) { return error < 1.0; }));
    EXPECT_LT(2 * num_right, compensated.size());
}

// With two cameras that run free the right image is the earlier one of some pairs.
TEST_F(LateRightImageTest, EachPairIsCompensatedByItsOwnGap) {
    const Eigen::AngleAxisd rotation(T_later_now_.linear());
    for (const double share : {-1.0, -0.5, 0.25, 0.75}) {
        Eigen::Isometry3d T_then_now = Eigen::Isometry3d::Identity();
        T_then_now.rotate(Eigen::AngleAxisd(share * rotation.angle(), rotation.axis()));
        T_then_now.translation() = share * T_later_now_.translation();
        expose_right(T_then_now);

        const std::vector<double> compensated = errors_px(synchronised(share));

        ASSERT_GE(compensated.size(), 40U) << share;
        EXPECT_LT(stats::median(compensated), 0.1) << share;
    }
}

TEST_F(LateRightImageTest, DenseDisparitiesAreCorrectedAlike) {
    const types::RectifiedFrame frame = synchronised();
    types::DepthMap depth;
    depth.disparity_px = cv::Mat(240, 320, CV_32F, 0.0F);
    for (int v = 20; v < 220; v += 10)
        for (int u = 60; u < 300; u += 10)
            depth.disparity_px.at<float>(v, u) = static_cast<float>(
                frame.matched_px(Eigen::Vector2d(u, v), true_disparity_px(u, v)));

    camera::correct_disparities(frame, depth);

    for (int v = 20; v < 220; v += 10)
        for (int u = 60; u < 300; u += 10)
            ASSERT_NEAR(depth.disparity_px.at<float>(v, u), true_disparity_px(u, v), 0.01);
    EXPECT_EQ(depth.disparity_px.at<float>(0, 0), 0.0F);
}

TEST_F(LateRightImageTest, NothingKnownBetweenThemChangesNothing) {
    const types::RectifiedFrame frame = camera::synchronise_pair(frame_, std::nullopt);
    EXPECT_EQ(cv::norm(frame.right, frame_.right, cv::NORM_INF), 0.0);
    EXPECT_EQ(frame.disparity_px({100.0, 100.0}, 12.0), 12.0);
}

}  // namespace
}  // namespace divemesh::features
