#include "worker/dive/mounting_check.hpp"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/worker/dive/finding_matcher.hpp"
#include "worker/dive/track_corners.hpp"

namespace divemesh::dive {
namespace {

constexpr int kDisparity_px = 9;

cv::Mat scene() {
    cv::Mat image(240, 320 + kDisparity_px, CV_8UC1);
    cv::RNG random(7);
    random.fill(image, cv::RNG::UNIFORM, 0, 255);
    cv::GaussianBlur(image, image, {}, 2.0);
    cv::normalize(image, image, 0, 255, cv::NORM_MINMAX);
    return image;
}

std::vector<Finding> check(const cv::Mat& left, const cv::Mat& right) {
    std::vector<cv::Point2f> corners;
    cv::goodFeaturesToTrack(left, corners, 250, 0.01, 12.0);
    std::vector<bool> found(corners.size(), true);
    const auto found_at = track_corners(left, right, corners, found);
    MountingCheck mounting;
    mounting.add(left, right, corners, found_at, found);
    FindingLog findings;
    mounting.report(findings);
    return findings.all();
}

class MountingCheckTest : public testing::Test {
protected:
    const cv::Mat left_ = scene().colRange(0, 320).clone();
    const cv::Mat right_ = scene().colRange(kDisparity_px, 320 + kDisparity_px).clone();
};

TEST_F(MountingCheckTest, APairAsItShouldBeIsAccepted) {
    EXPECT_TRUE(check(left_, right_).empty());
}

TEST_F(MountingCheckTest, ATurnedCameraIsNamed) {
    cv::Mat turned;
    cv::rotate(right_, turned, cv::ROTATE_180);
    EXPECT_THAT(check(left_, turned), HasFinding(Severity::Error, "camera_turned", "by 180"));
    cv::flip(right_, turned, 1);
    EXPECT_THAT(check(left_, turned),
                HasFinding(Severity::Error, "camera_turned", "left to right"));
    cv::flip(right_, turned, 0);
    EXPECT_THAT(check(left_, turned),
                HasFinding(Severity::Error, "camera_turned", "top to bottom"));
}

TEST_F(MountingCheckTest, OneCameraInBothFoldersIsNamed) {
    EXPECT_THAT(check(left_, left_),
                HasFinding(Severity::Error, "cameras_identical", "same pixel"));
    // Compressed anew, it is not the same file.
    cv::Mat noise(left_.size(), CV_8UC1);
    cv::RNG(3).fill(noise, cv::RNG::UNIFORM, 0, 4);
    EXPECT_THAT(check(left_, left_ + noise), HasFinding(Severity::Error, "cameras_identical", ""));
}

TEST_F(MountingCheckTest, ImagesOfDifferentPlacesAreNotExplained) {
    cv::Mat other(240, 320, CV_8UC1);
    cv::RNG(9).fill(other, cv::RNG::UNIFORM, 0, 255);
    cv::GaussianBlur(other, other, {}, 2.0);
    EXPECT_TRUE(check(left_, other).empty());
}

}  // namespace
}  // namespace divemesh::dive
