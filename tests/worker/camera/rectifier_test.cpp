#include "worker/camera/rectifier.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <opencv2/imgproc.hpp>

#include "schemas/error.hpp"
#include "tests/synthetic/sensor_recording.hpp"
#include "worker/base/rotation_vector.hpp"
#include "worker/camera/projection.hpp"
#include "worker/camera/right_camera_at.hpp"

namespace divemesh::camera {
namespace {

types::Rig converging_rig() {
    types::Rig rig;
    rig.cam0 = {640,
                480,
                489.6,
                489.1,
                320.9,
                238.8,
                types::Distortion::RadialTangential,
                {-0.121, 0.0312, 0.00041, -0.00032}};
    rig.cam1 = {640,
                480,
                491.7,
                491.2,
                318.3,
                241.4,
                types::Distortion::RadialTangential,
                {-0.118, 0.0287, -0.00026, 0.00053}};
    Eigen::Isometry3d T_cam0_cam1 = Eigen::Isometry3d::Identity();
    T_cam0_cam1.linear() = base::rotation_from_vector({0.008, -0.012, 0.005}).toRotationMatrix();
    T_cam0_cam1.translation() << 0.12, 0.002, -0.003;
    rig.T_imu_cam0.linear() = base::rotation_from_vector({0.3, 0.2, 1.5}).toRotationMatrix();
    rig.T_imu_cam0.translation() << 0.05, -0.02, 0.01;
    rig.T_imu_cam1 = rig.T_imu_cam0 * T_cam0_cam1;
    return rig;
}

// Returns an image with one soft dot where the camera sees the point.
cv::Mat dot(const types::Camera& camera, const Eigen::Vector3d& p_cam) {
    cv::Mat image(camera.height_px, camera.width_px, CV_8U, cv::Scalar(0));
    const Eigen::Vector2d at = *project(camera, p_cam);
    for (int v = 0; v < image.rows; ++v)
        for (int u = 0; u < image.cols; ++u)
            image.at<std::uint8_t>(v, u) = static_cast<std::uint8_t>(
                std::lround(250.0 * std::exp(-(Eigen::Vector2d(u, v) - at).squaredNorm() / 18.0)));
    return image;
}

Eigen::Vector2d centre(const cv::Mat& image) {
    const cv::Moments moments = cv::moments(image);
    return {moments.m10 / moments.m00, moments.m01 / moments.m00};
}

TEST(RectifierTest, PutsAPointOnOneRowWithTheDisparityOfItsDepth) {
    const types::Rig rig = converging_rig();
    const Rectifier rectifier(rig);
    const types::RectifiedRig& ideal = rectifier.rig();
    for (const Eigen::Vector3d& p_cam : {Eigen::Vector3d(0.1, 0.1, 1.0),
                                         Eigen::Vector3d(-0.6, 0.5, 2.0),
                                         Eigen::Vector3d(1.0, -0.8, 3.0)}) {
        const Eigen::Vector3d p_imu = ideal.T_imu_cam * p_cam;
        types::StereoFrame frame;
        frame.left = dot(rig.cam0, rig.T_imu_cam0.inverse() * p_imu);
        frame.right = dot(rig.cam1, rig.T_imu_cam1.inverse() * p_imu);

        const types::RectifiedFrame rectified = rectifier.rectify(frame);

        const Eigen::Vector2d left = centre(rectified.left);
        const Eigen::Vector2d right = centre(rectified.right);
        EXPECT_LT((left - ideal.pixel(p_cam)).norm(), 0.1);
        EXPECT_NEAR(left.y(), right.y(), 0.1);
        EXPECT_NEAR(left.x() - right.x(), ideal.disparity_px(p_cam.z()), 0.1);
    }
}

TEST(RectifierTest, PutsAPointOnItsRowAfterTheRightCameraWasKnocked) {
    const types::Rig before = converging_rig();
    types::Rig after = before;
    const Eigen::Vector3d rotation(0.006, -0.004, 0.008);
    after.T_imu_cam1.rotate(base::rotation_from_vector(rotation));
    after.cam1.fx_px *= 1.01;
    after.cam1.fy_px *= 1.01;
    types::Rig knocked = before;
    knocked.right_turns = {{.from_ns = 100, .rotation = rotation, .focal = 0.01}, {.from_ns = 200}};
    for (const std::int64_t time_ns : {99, 100, 199, 200}) {
        const types::Rig& rig = time_ns < 100 || time_ns >= 200 ? before : after;
        const MountedCamera right = right_camera_at(knocked, time_ns);
        EXPECT_TRUE(right.T_imu_cam.isApprox(rig.T_imu_cam1, 1e-12)) << time_ns;
        EXPECT_NEAR(right.camera.fx_px, rig.cam1.fx_px, 1e-9) << time_ns;
    }
    const Rectifier rectifier(knocked);
    const types::RectifiedRig& ideal = rectifier.rig();
    const Eigen::Vector3d p_cam(-0.4, 0.3, 1.6);
    const Eigen::Vector3d p_imu = ideal.T_imu_cam * p_cam;
    for (const auto& [time_ns, rig] : {std::pair<std::int64_t, const types::Rig*>(99, &before),
                                       std::pair<std::int64_t, const types::Rig*>(100, &after),
                                       std::pair<std::int64_t, const types::Rig*>(199, &after),
                                       std::pair<std::int64_t, const types::Rig*>(200, &before)}) {
        types::StereoFrame frame;
        frame.timestamp_ns = time_ns;
        frame.left = dot(rig->cam0, rig->T_imu_cam0.inverse() * p_imu);
        frame.right = dot(rig->cam1, rig->T_imu_cam1.inverse() * p_imu);

        const types::RectifiedFrame rectified = rectifier.rectify(frame);

        const Eigen::Vector2d right = centre(rectified.right);
        const Eigen::Vector2d left = ideal.pixel(p_cam);
        EXPECT_NEAR(right.y(), left.y(), 0.1) << time_ns;
        EXPECT_NEAR(left.x() - right.x(), ideal.disparity_px(p_cam.z()), 0.1) << time_ns;
    }
}

// Returns an image as one loop over all pixels rectifies it.
cv::Mat plainly_rectified(const cv::Mat& image,
                          const RectifiedLens& lens,
                          const types::RectifiedRig& rig) {
    cv::Mat x(rig.height_px, rig.width_px, CV_32F);
    cv::Mat y(rig.height_px, rig.width_px, CV_32F);
    for (int v = 0; v < rig.height_px; ++v)
        for (int u = 0; u < rig.width_px; ++u) {
            const Eigen::Vector2d pixel = lens.recorded_px(rig, Eigen::Vector2d(u, v));
            x.at<float>(v, u) = static_cast<float>(pixel.x());
            y.at<float>(v, u) = static_cast<float>(pixel.y());
        }
    cv::Mat pixels, parts, result;
    cv::convertMaps(x, y, pixels, parts, CV_16SC2);
    cv::remap(image, result, pixels, parts, cv::INTER_LINEAR);
    return result;
}

TEST(RectifierTest, GivesTheBytesOfAPlainLoop) {
    synthetic::SensorRecording recording;
    recording.its_rig = converging_rig();
    recording.its_rig.cam0.width_px = recording.its_rig.cam1.width_px = 637;
    const types::Rig& rig = recording.its_rig;
    cv::RNG random(11);
    types::StereoFrame frame;
    cv::Mat color(480, 637, CV_8UC3);
    frame.left.create(480, 637, CV_8U);
    frame.right.create(480, 637, CV_8U);
    for (cv::Mat* image : {&frame.left, &frame.right, &color})
        random.fill(*image, cv::RNG::UNIFORM, 0, 256);
    const Rectifier rectifier(rig);

    const types::RectifiedFrame rectified = rectifier.rectify(frame);

    const auto difference = [&](const cv::Mat& found, const cv::Mat& recorded, std::size_t side) {
        const RectifiedLens lens = rectified_lenses(rig)[side];
        return cv::norm(found, plainly_rectified(recorded, lens, rectifier.rig()), cv::NORM_INF);
    };
    EXPECT_EQ(difference(rectified.left, frame.left, 0), 0.0);
    EXPECT_EQ(difference(rectified.right, frame.right, 1), 0.0);
    EXPECT_EQ(difference(left_rectifier(recording).rectify(color), color, 0), 0.0);
}

TEST(RectifierTest, TakesTheMiddleOfAFisheyeImageThatSeesBehindItself) {
    types::Rig rig = converging_rig();
    // At 150 px a radian the corners are 150 degrees off the axis.
    rig.cam0 = {640, 480, 150.0, 150.0, 310.0, 246.0, types::Distortion::Equidistant, {}};
    rig.cam1 = {640, 480, 150.0, 150.0, 325.0, 237.0, types::Distortion::Equidistant, {}};

    const types::RectifiedRig ideal = Rectifier(rig).rig();

    EXPECT_NEAR(ideal.focal_px, 75.0, 1e-9);
    EXPECT_NEAR(ideal.cx_px, 319.5, 1e-9);
    EXPECT_NEAR(ideal.cy_px, 239.5, 1e-9);
}

// A fisheye image of which only a part in the middle shows the scene, as of a lens made for a
// smaller sensor.
TEST(RectifierTest, KeepsTheResolutionOfASceneOnBlack) {
    types::Rig rig = converging_rig();
    rig.cam0 = {640, 480, 200.0, 200.0, 320.0, 240.0, types::Distortion::Equidistant, {}};
    rig.cam1 = rig.cam0;
    cv::Mat fixed_pattern(480, 640, CV_8U, cv::Scalar(255));
    fixed_pattern(cv::Rect(240, 180, 160, 120)) = 0;

    const types::RectifiedRig without = Rectifier(rig).rig();
    synthetic::SensorRecording recording;
    recording.its_rig = rig;
    recording.its_fixed_pattern = fixed_pattern;
    const Rectifier rectifier(recording);
    types::StereoFrame frame;
    frame.left = frame.right = cv::Mat::zeros(480, 640, CV_8U);
    const types::RectifiedFrame rectified = rectifier.rectify(frame);

    EXPECT_NEAR(without.focal_px, 100.0, 1e-9);
    EXPECT_NEAR(rectifier.rig().focal_px, 200.0, 1e-9);
    const cv::Rect scene = cv::boundingRect(rectified.fixed_pattern == 0);
    EXPECT_GE(scene.width, 160);
    EXPECT_GE(scene.height, 120);
    EXPECT_FALSE(rectified.shows_scene({5.0, 5.0}));
    EXPECT_TRUE(rectified.shows_scene(
        Eigen::Vector2d(0.5 * (scene.tl().x + scene.br().x), 0.5 * (scene.tl().y + scene.br().y))));
}

// A black band on the right moves the scene to the middle, and the left border becomes empty.
TEST(RectifierTest, WhatLiesBeyondTheRecordedImageIsNoScene) {
    types::Rig rig = converging_rig();
    rig.cam0 = {640, 480, 500.0, 500.0, 320.0, 240.0, types::Distortion::None, {}};
    rig.cam1 = rig.cam0;
    cv::Mat fixed_pattern = cv::Mat::zeros(480, 640, CV_8U);
    fixed_pattern.colRange(560, 640) = 255;
    const Rectifier rectifier(rig, fixed_pattern);
    types::StereoFrame frame;
    frame.left = frame.right = cv::Mat(480, 640, CV_8U, cv::Scalar(200));

    const types::RectifiedFrame rectified = rectifier.rectify(frame);

    cv::Mat empty;
    cv::erode(rectified.left == 0, empty, cv::Mat::ones(3, 3, CV_8U));  // not pixels of the border
    ASSERT_GT(cv::countNonZero(empty), 1000);
    EXPECT_EQ(cv::countNonZero(empty & (rectified.fixed_pattern == 0)), 0);
}

TEST(RectifierTest, RefusesCamerasThatAreSwapped) {
    types::Rig rig = converging_rig();
    std::swap(rig.T_imu_cam0, rig.T_imu_cam1);
    EXPECT_THROW(Rectifier{rig}, Error);
}

}  // namespace
}  // namespace divemesh::camera
