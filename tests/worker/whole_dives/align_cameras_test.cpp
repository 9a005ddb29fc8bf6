#include "worker/pipeline/align_cameras.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <opencv2/imgproc.hpp>

#include "tests/synthetic/altered_recording.hpp"
#include "tests/worker/whole_dives/short_tank_dive.hpp"
#include "worker/base/rotation_vector.hpp"
#include "worker/calibration/stereo_alignment.hpp"
#include "worker/camera/projection.hpp"
#include "worker/pipeline/aligned_recording.hpp"
#include "worker/pipeline/alignment_findings.hpp"

namespace divemesh::pipeline {
namespace {

using Outcome = types::RigAlignment::Outcome;

constexpr double kDeg = std::numbers::pi / 180.0;

// The dive is read with a calibration in which the right camera is turned.
class AlignCamerasTest : public ShortTankDive {
protected:
    static void SetUpTestSuite() { render(0.4); }
    types::RigAlignment align(const Eigen::Vector3d& degrees) {
        AlignedRecording recording(*dive_);
        types::Rig turned = dive_->rig();
        turned.T_imu_cam1.rotate(base::rotation_from_vector(kDeg * degrees));
        recording.set_rig(turned);
        const types::RigAlignment found = align_cameras(recording, 0, base::ignore_progress);
        const types::RigChange change =
            found.outcome == Outcome::Moved ? found.change : types::RigChange{};
        const types::Rig aligned = calibration::changed_rig(turned, change);
        error_ = base::vector_from_rotation(Eigen::Quaterniond(
                     (aligned.T_imu_cam1.inverse() * dive_->rig().T_imu_cam1).linear())) /
                 kDeg;
        return found;
    }

    Eigen::Vector3d error_ = Eigen::Vector3d::Zero();  // degrees, of the aligned right camera
};

TEST_F(AlignCamerasTest, ARightCalibrationStaysAndIsNoFinding) {
    const types::RigAlignment found = align({0.0, 0.0, 0.0});

    EXPECT_EQ(found.outcome, Outcome::AsStated);
    EXPECT_TRUE(alignment_findings(found).empty());
}

TEST_F(AlignCamerasTest, AKnockedCameraIsFoundAndTold) {
    const types::RigAlignment found = align({0.8, 0.0, -0.5});

    EXPECT_EQ(found.outcome, Outcome::Moved);
    EXPECT_LT(std::hypot(error_.x(), error_.z()), 0.05);
    const std::vector<Finding> findings = alignment_findings(found);
    ASSERT_EQ(findings.size(), 1U);
    EXPECT_EQ(findings[0].code, "stereo_mismatch");
}

TEST_F(AlignCamerasTest, AnImageThatIsShiftedOnItsSensorIsFoundAndTold) {
    AlignedRecording recording(*dive_);
    types::Rig shifted = dive_->rig();
    shifted.cam1.cy_px -= 6.0;
    recording.set_rig(shifted);

    const types::RigAlignment found = align_cameras(recording, 0, base::ignore_progress);

    EXPECT_EQ(found.outcome, Outcome::Moved);
    EXPECT_NEAR(found.change.values[types::RigChange::kCentreDown], 6.0, 0.1);
    EXPECT_LT(found.change.values.head<3>().norm() / kDeg, 0.05);
    const std::vector<Finding> findings = alignment_findings(found);
    ASSERT_EQ(findings.size(), 1U);
    EXPECT_NE(findings[0].message.find("its image is shifted down by 6.0 px"), std::string::npos)
        << findings[0].message;
}

TEST_F(AlignCamerasTest, AYawIsFoundByRanges) {
    const types::RigAlignment found = align({0.0, 0.7, 0.0});

    EXPECT_EQ(found.outcome, Outcome::Moved);
    EXPECT_LT(std::abs(error_.y()), 0.15);
    EXPECT_GT(found.num_windows, 0);
}

// A calibration whose makers scaled it to air.
TEST_F(AlignCamerasTest, FocalLengthsOfAnotherMediumAreFoundAndTold) {
    AlignedRecording recording(*dive_);
    types::Rig in_air = dive_->rig();
    for (types::Camera* camera : {&in_air.cam0, &in_air.cam1}) {
        camera->fx_px /= 1.333;
        camera->fy_px /= 1.333;
    }
    recording.set_rig(in_air);

    const types::RigAlignment found = align_cameras(recording, 0, base::ignore_progress);

    EXPECT_NEAR(found.change.medium.focal_scale, 1.337, 1e-12);
    EXPECT_EQ(found.change.medium.refractive_index, 1.0);
    const std::vector<Finding> findings = alignment_findings(found);
    ASSERT_FALSE(findings.empty());
    EXPECT_EQ(findings[0].code, "calibration_medium");
}

// Makes the image that a camera takes behind a flat port: `in_air` is its calibration without it.
// Snell's law is written down here once more, by angles.
cv::Mat behind_port(const cv::Mat& image,
                    const types::Camera& seen_by,
                    const types::Camera& in_air) {
    cv::Mat x(image.size(), CV_32F);
    cv::Mat y(image.size(), CV_32F);
    for (int v = 0; v < image.rows; ++v)
        for (int u = 0; u < image.cols; ++u) {
            const Eigen::Vector3d ray = camera::unproject(in_air, Eigen::Vector2d(u, v));
            const double distance = ray.head<2>().norm();
            const double in_water = std::asin(std::sin(std::atan(distance)) / 1.337);
            const Eigen::Vector2d n =
                std::tan(in_water) / std::max(distance, 1e-12) * ray.head<2>();
            const Eigen::Vector2d at = *camera::project(seen_by, {n.x(), n.y(), 1.0});
            x.at<float>(v, u) = static_cast<float>(at.x());
            y.at<float>(v, u) = static_cast<float>(at.y());
        }
    cv::Mat result;
    cv::remap(image, result, x, y, cv::INTER_CUBIC);
    return result;
}

TEST_F(AlignCamerasTest, ACalibrationInAirBehindAFlatPortIsFoundAndTold) {
    types::Rig in_air = dive_->rig();
    for (types::Camera* camera : {&in_air.cam0, &in_air.cam1}) {
        camera->fx_px /= 1.337;
        camera->fy_px /= 1.337;
        camera->distortion = types::Distortion::None;
    }
    synthetic::AlteredRecording altered(*dive_, [&](types::StereoFrame& frame) {
        frame.left = behind_port(frame.left, dive_->rig().cam0, in_air.cam0);
        frame.right = behind_port(frame.right, dive_->rig().cam1, in_air.cam1);
    });
    AlignedRecording recording(altered);
    recording.set_rig(in_air);

    const types::RigAlignment found = align_cameras(recording, 0, base::ignore_progress);

    EXPECT_NEAR(found.change.medium.refractive_index, 1.337, 1e-12);
    EXPECT_EQ(found.change.medium.focal_scale, 1.0);
    const std::vector<Finding> findings = alignment_findings(found);
    ASSERT_FALSE(findings.empty());
    EXPECT_EQ(findings[0].code, "calibration_medium");
    // The right camera itself stands as stated, so that nothing else is changed.
    EXPECT_LT(found.change.values.head<3>().norm(), 0.1 * kDeg);
}

// Makes the image of a camera that is turned about its own axes.
cv::Mat turned_image(const cv::Mat& image,
                     const types::Camera& camera,
                     const Eigen::Vector3d& deg) {
    const Eigen::Matrix3d R = base::rotation_from_vector(kDeg * deg).toRotationMatrix();
    cv::Mat x(image.size(), CV_32F);
    cv::Mat y(image.size(), CV_32F);
    for (int v = 0; v < image.rows; ++v)
        for (int u = 0; u < image.cols; ++u) {
            const Eigen::Vector3d ray = R * camera::unproject(camera, Eigen::Vector2d(u, v));
            const Eigen::Vector2d at =
                camera::project(camera, ray).value_or(Eigen::Vector2d(-1.0, -1.0));
            x.at<float>(v, u) = static_cast<float>(at.x());
            y.at<float>(v, u) = static_cast<float>(at.y());
        }
    cv::Mat result;
    cv::remap(image, result, x, y, cv::INTER_CUBIC, cv::BORDER_REPLICATE);
    return result;
}

class KnockInMidDiveTest : public ShortTankDive {
protected:
    static void SetUpTestSuite() { render(1.2); }
};

TEST_F(KnockInMidDiveTest, IsFoundToTheFrameAndTold) {
    const Eigen::Vector3d degrees(0.45, 0.0, -0.6);
    const int knocked_at = 2 * dive_->num_frames() / 5;
    synthetic::AlteredRecording altered(*dive_, [&](types::StereoFrame& frame) {
        if (frame.index >= knocked_at)
            frame.right = turned_image(frame.right, dive_->rig().cam1, degrees);
    });

    const types::RigAlignment found = align_cameras(altered, 0, base::ignore_progress);

    ASSERT_EQ(found.parts.size(), 2U);
    EXPECT_EQ(found.parts[1].first_frame, knocked_at);
    EXPECT_EQ(found.parts[0].num_frames + found.parts[1].num_frames, dive_->num_frames());
    ASSERT_TRUE(found.parts[0].found && found.parts[1].found);
    const Eigen::Vector3d turn_deg =
        (found.parts[1].values - found.parts[0].values).head<3>() / kDeg;
    EXPECT_LT((turn_deg - degrees).norm(), 0.08) << turn_deg.transpose();
    const std::vector<Finding> findings = alignment_findings(found);
    ASSERT_FALSE(findings.empty());
    EXPECT_EQ(findings[0].code, "rig_moved");
    EXPECT_NE(findings[0].message.find("frame " + std::to_string(knocked_at)), std::string::npos);
}

}  // namespace
}  // namespace divemesh::pipeline
