#include "worker/camera/shutter_correction.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tests/synthetic/ideal_rig.hpp"
#include "worker/base/rotation_vector.hpp"

namespace divemesh::camera {
namespace {

constexpr double kReadout_s = 0.03;
constexpr int kFrame = 7;
const CameraMotion kMotion{{0.6, -0.8, 0.8}, {0.8, 0.5, -0.6}};

// Returns the pose of the camera some time after the middle row, in the frame it has then.
Eigen::Isometry3d pose_after(double late_s) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() =
        base::rotation_from_vector(late_s * kMotion.angular_velocity_cam).toRotationMatrix();
    pose.translation() = late_s * kMotion.velocity_cam;
    return pose;
}

// A sloping floor, seen by an ideal pair.
class ShutterCorrectionTest : public testing::Test {
protected:
    // Returns disparity and a colour that tells the place on the floor, of a pixel read late.
    Eigen::Vector4d seen(int u, int v, double readout_s) const {
        const Eigen::Isometry3d pose = pose_after(readout_s * (double(v) / rig_.height_px - 0.5));
        const Eigen::Vector3d ray = pose.linear() * rig_.point_cam(u, v, 1.0);
        const double depth_m =
            (floor_.w() - floor_.head<3>().dot(pose.translation())) / floor_.head<3>().dot(ray);
        const Eigen::Vector3d p = pose.translation() + depth_m * ray;
        return {rig_.focal_px * rig_.baseline_m / depth_m,
                128.0 + 100.0 * std::sin(6.0 * p.x()),
                128.0 + 100.0 * std::sin(6.0 * p.y()),
                128.0};
    }
    types::KeyframeImages images(double readout_s) const {
        types::KeyframeImages images;
        images.left_color.create(rig_.height_px, rig_.width_px, CV_8UC3);
        images.depth.disparity_px.create(rig_.height_px, rig_.width_px, CV_32F);
        images.depth.sigma_disparity_px = cv::Mat(rig_.height_px, rig_.width_px, CV_32F, 0.25F);
        for (int v = 0; v < rig_.height_px; ++v)
            for (int u = 0; u < rig_.width_px; ++u) {
                const Eigen::Vector4d pixel = seen(u, v, readout_s);
                images.depth.disparity_px.at<float>(v, u) = static_cast<float>(pixel[0]);
                images.left_color.at<cv::Vec3b>(v, u) =
                    cv::Vec3b(cv::saturate_cast<std::uint8_t>(pixel[1]),
                              cv::saturate_cast<std::uint8_t>(pixel[2]),
                              cv::saturate_cast<std::uint8_t>(pixel[3]));
            }
        return images;
    }
    // Returns the largest difference of disparity and of colour, away from the borders.
    static std::pair<double, double> differences(const types::KeyframeImages& a,
                                                 const types::KeyframeImages& b) {
        const cv::Rect inner(20, 20, a.left_color.cols - 40, a.left_color.rows - 40);
        return {cv::norm(a.depth.disparity_px(inner), b.depth.disparity_px(inner), cv::NORM_INF),
                cv::norm(a.left_color(inner), b.left_color(inner), cv::NORM_INF)};
    }

    types::RectifiedRig rig_ = synthetic::ideal_rig(320, 240, 250.0);
    const Eigen::Vector4d floor_{0.1, -0.3, 1.0, 2.0};  // normal and distance, m
    const ShutterCorrection correction_{
        rig_, rectified_lenses(synthetic::ideal_cameras(rig_))[0], kReadout_s, {{kFrame, kMotion}}};
};

TEST_F(ShutterCorrectionTest, ImagesAndDepthAreThoseOfAGlobalShutter) {
    const types::KeyframeImages global = images(0.0);
    const types::KeyframeImages rolling = images(kReadout_s);
    const auto before = differences(rolling, global);
    const auto after = differences(correction_.moved(kFrame, rolling), global);
    EXPECT_GT(before.first, 0.1);
    EXPECT_GT(before.second, 8.0);
    EXPECT_LT(after.first, 0.02);
    EXPECT_LT(after.second, 3.0);
}

TEST_F(ShutterCorrectionTest, HolesStayHolesAndMoveWithTheImage) {
    types::KeyframeImages rolling = images(kReadout_s);
    rolling.depth.disparity_px(cv::Rect(100, 180, 40, 30)).setTo(0.0F);
    const types::KeyframeImages moved = correction_.moved(kFrame, rolling);
    const int num_holes = 320 * 240 - cv::countNonZero(moved.depth.disparity_px);
    EXPECT_EQ(cv::countNonZero(moved.depth.disparity_px(cv::Rect(104, 184, 32, 22))), 0);
    EXPECT_LT(num_holes, 50 * 40 + 320 * 240 / 10);  // that hole, and what came into the image
    EXPECT_EQ(moved.depth.sigma_disparity_px.at<float>(60, 160), 0.25F);
}

TEST_F(ShutterCorrectionTest, TheCameraMovesUntilARowIsRead) {
    const Eigen::Isometry3d expected = pose_after(kReadout_s * (60.0 / 240.0 - 0.5));
    EXPECT_TRUE(correction_.motion_until_row(kFrame, {100.0, 60.0}).isApprox(expected, 1e-9));
}

TEST_F(ShutterCorrectionTest, AFrameOfUnknownMotionStays) {
    const types::KeyframeImages rolling = images(kReadout_s);
    EXPECT_EQ(differences(correction_.moved(kFrame + 1, rolling), rolling), std::pair(0.0, 0.0));
    EXPECT_TRUE(correction_.motion_until_row(kFrame + 1, {10.0, 10.0})
                    .isApprox(Eigen::Isometry3d::Identity()));
}

}  // namespace
}  // namespace divemesh::camera
