#include "worker/camera/rectifier.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "schemas/error.hpp"
#include "worker/base/rotation_vector.hpp"
#include "worker/camera/projection.hpp"

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

TEST(RectifierTest, RefusesCamerasThatAreSwapped) {
    types::Rig rig = converging_rig();
    std::swap(rig.T_imu_cam0, rig.T_imu_cam1);
    EXPECT_THROW(Rectifier{rig}, Error);
}

}  // namespace
}  // namespace divemesh::camera
