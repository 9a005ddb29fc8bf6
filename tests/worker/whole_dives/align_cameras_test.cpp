#include "worker/pipeline/align_cameras.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <numbers>

#include "tests/temporary_folder.hpp"
#include "worker/base/rotation_vector.hpp"
#include "worker/calibration/stereo_alignment.hpp"
#include "worker/dive/dive.hpp"
#include "worker/pipeline/aligned_recording.hpp"
#include "worker/simulator/simulate.hpp"

namespace divemesh::pipeline {
namespace {

using Outcome = types::RigAlignment::Outcome;

constexpr double kDeg = std::numbers::pi / 180.0;

// A short rendered dive, read with a calibration in which the right camera is turned.
class AlignCamerasTest : public testing::Test {
protected:
    static void SetUpTestSuite() {
        folder_ = std::make_unique<TemporaryFolder>();
        simulator::simulate({.scene = simulator::SceneKind::Tank,
                             .out = *folder_ / "dive",
                             .length_m = 0.4,
                             .rate_hz = 8.0,
                             .width_px = 320,
                             .height_px = 240});
        dive_ = dive::Dive::open(*folder_ / "dive", *folder_ / "scratch");
    }
    static void TearDownTestSuite() {
        dive_.reset();
        folder_.reset();
    }
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

    static inline std::unique_ptr<TemporaryFolder> folder_;
    static inline std::unique_ptr<dive::Dive> dive_;
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

TEST_F(AlignCamerasTest, AYawIsFoundByRanges) {
    const types::RigAlignment found = align({0.0, 0.7, 0.0});

    EXPECT_EQ(found.outcome, Outcome::Moved);
    EXPECT_LT(std::abs(error_.y()), 0.15);
    EXPECT_GT(found.num_windows, 0);
}

}  // namespace
}  // namespace divemesh::pipeline
