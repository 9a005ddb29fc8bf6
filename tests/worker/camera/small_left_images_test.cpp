#include "worker/camera/small_left_images.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "tests/synthetic/sensor_recording.hpp"
#include "worker/base/rotation_vector.hpp"
#include "worker/camera/rectifier.hpp"

namespace divemesh::camera {
namespace {

constexpr int kWidth_px = 320;

types::Rig rig_of(int width_px, int height_px) {
    types::Rig rig;
    rig.cam0 = {width_px,
                height_px,
                0.76 * width_px,
                0.77 * width_px,
                0.51 * width_px,
                0.48 * height_px,
                types::Distortion::RadialTangential,
                {-0.12, 0.031, 4e-4, -3e-4}};
    rig.cam1 = rig.cam0;
    rig.T_imu_cam1.linear() = base::rotation_from_vector({0.01, -0.02, 0.03}).toRotationMatrix();
    rig.T_imu_cam1.translation() = Eigen::Vector3d(0.12, 0.002, -0.003);
    return rig;
}

// A recording of one image.
struct OneImage : synthetic::SensorRecording {
    OneImage(int width_px, int height_px) : whole(height_px, width_px, CV_8UC3) {
        its_rig = rig_of(width_px, height_px);
        cv::RNG(4).fill(whole, cv::RNG::UNIFORM, 0, 256);
        cv::GaussianBlur(whole, whole, {}, 0.01 * width_px);
        cv::normalize(whole, whole, 0, 255, cv::NORM_MINMAX);
    }
    cv::Mat left_in_color(int, int reduction) const override {
        cv::Mat image;
        const cv::Size size(whole.cols / reduction, whole.rows / reduction);
        cv::resize(whole(cv::Rect({}, size * reduction)), image, size, 0.0, 0.0, cv::INTER_AREA);
        return image;
    }

    cv::Mat whole;
};

double mean_difference(const cv::Mat& a, const cv::Mat& b) {
    return cv::norm(a, b, cv::NORM_L1) / static_cast<double>(3 * a.total());
}

TEST(SmallLeftImagesTest, AreTheWholeOnesReduced) {
    for (const cv::Size size : {cv::Size(1920, 1080), cv::Size(1283, 965), cv::Size(640, 480)}) {
        const OneImage recording(size.width, size.height);
        const RectifiedLens left = rectified_lenses(recording.rig())[0];
        const SmallLeftImages images(recording, left, rectified_rig(recording.rig()), kWidth_px);

        const cv::Mat small = images.read(0);

        const double scale = static_cast<double>(kWidth_px) / size.width;
        cv::Mat expected;
        cv::resize(left_rectifier(recording).rectify(recording.whole),
                   expected,
                   {},
                   scale,
                   scale,
                   cv::INTER_AREA);
        ASSERT_EQ(small.size(), expected.size());
        EXPECT_LT(mean_difference(small, expected), 2.0) << size.width;
        cv::Mat beside;  // by one pixel
        cv::copyMakeBorder(
            expected.colRange(1, kWidth_px), beside, 0, 0, 0, 1, cv::BORDER_REPLICATE);
        EXPECT_GT(mean_difference(beside, expected), 3.0) << size.width;
    }
}

TEST(SmallLeftImagesTest, SmallerOnesStayAsTheyAre) {
    const OneImage recording(240, 180);
    const RectifiedLens left = rectified_lenses(recording.rig())[0];
    const SmallLeftImages images(recording, left, rectified_rig(recording.rig()), kWidth_px);
    EXPECT_EQ(
        cv::norm(images.read(0), left_rectifier(recording).rectify(recording.whole), cv::NORM_INF),
        0.0);
}

}  // namespace
}  // namespace divemesh::camera
