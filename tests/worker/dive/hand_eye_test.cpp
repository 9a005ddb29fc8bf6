#include "worker/dive/hand_eye.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <fstream>
#include <iterator>
#include <random>

#include "tests/paths.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/worker/dive/finding_matcher.hpp"
#include "worker/dive/dive.hpp"

namespace divemesh::dive {
namespace {

// Returns the motion of a rig that rotates at random, measured by a gyroscope with bias and noise.
std::vector<RotationPair> random_motion(const Eigen::Matrix3d& R_imu_cam0) {
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    const auto vector = [&](double sigma) {
        return Eigen::Vector3d(
            sigma * normal(random), sigma * normal(random), sigma * normal(random));
    };
    const Eigen::Vector3d bias(0.08, -0.02, 0.05);
    std::vector<RotationPair> pairs;
    for (int i = 0; i < 12; ++i) {
        const Eigen::Vector3d rate_imu = vector(0.2);
        pairs.push_back({rate_imu + bias + vector(0.005), R_imu_cam0.transpose() * rate_imu});
    }
    return pairs;
}

const Eigen::Matrix3d kMounting =
    (Eigen::AngleAxisd(1.4, Eigen::Vector3d(0.2, 0.3, 0.9).normalized())).toRotationMatrix();

std::vector<Finding> findings_for(const std::vector<RotationPair>& pairs,
                                  const Eigen::Matrix3d& R) {
    FindingLog log;
    report_hand_eye(pairs, R, log);
    return log.all();
}

TEST(HandEyeTest, TheRightMountingFitsInSpiteOfGyroBias) {
    const HandEye result = compare_rotations(random_motion(kMounting), kMounting);

    EXPECT_LT(result.given_residual, 0.1);
    EXPECT_GT(result.inverse_residual, 0.5);
    EXPECT_LT(result.best_angle_deg, 3.0);
    EXPECT_TRUE(findings_for(random_motion(kMounting), kMounting).empty());
}

TEST(HandEyeTest, AnInvertedMountingIsSaid) {
    EXPECT_THAT(findings_for(random_motion(kMounting), kMounting.transpose()),
                HasFinding(Severity::Error, "extrinsics_inverted", "T_BS looks inverted"));
}

TEST(HandEyeTest, AMountingOnAnotherAxisIsSaidWithItsAngle) {
    const Eigen::Matrix3d wrong =
        kMounting * Eigen::AngleAxisd(0.5 * M_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();

    EXPECT_THAT(findings_for(random_motion(kMounting), wrong),
                HasFinding(Severity::Error, "extrinsics_rotation", "degrees"));
}

// A motion that images measured wrongly may turn the best fit far away; the stated mounting fits
// all others.
TEST(HandEyeTest, AWrongMotionAmongRightOnesRefutesNoMounting) {
    int num_led_astray = 0;
    for (std::size_t wrong = 0; wrong < 12; ++wrong) {
        auto pairs = random_motion(kMounting);
        pairs[wrong].vision_cam0 = Eigen::Vector3d(1.2, -1.0, 0.8);

        const HandEye result = compare_rotations(pairs, kMounting);

        if (result.best_is_determined && result.best_angle_deg > 20.0) ++num_led_astray;
        EXPECT_LT(result.given_residual, 0.2) << wrong;
        EXPECT_TRUE(findings_for(pairs, kMounting).empty()) << wrong;
    }
    EXPECT_GT(num_led_astray, 3);
}

// By an angle whose refutation is not clear, the dive is taken with a warning.
TEST(HandEyeTest, ADoubtfulMountingIsAWarning) {
    std::mt19937 random(5);
    std::normal_distribution<double> normal(0.0, 0.045);
    auto pairs = random_motion(kMounting);
    for (RotationPair& pair : pairs)
        pair.vision_cam0 += Eigen::Vector3d(normal(random), normal(random), normal(random));
    const Eigen::Matrix3d wrong =
        kMounting * Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitX()).toRotationMatrix();
    const HandEye result = compare_rotations(pairs, wrong);
    ASSERT_GT(result.best_angle_deg, 20.0);
    ASSERT_LT(result.given_residual, 0.5);
    ASSERT_LT(result.given_residual, 2.0 * result.best_residual) << "else it is an error";

    EXPECT_THAT(findings_for(pairs, wrong),
                HasFinding(Severity::Warning, "gyro_vision_mismatch", "do not match"));
}

TEST(HandEyeTest, AGyroInDegreesIsSaid) {
    auto pairs = random_motion(kMounting);
    for (RotationPair& pair : pairs) pair.gyro_imu *= 180.0 / M_PI;

    EXPECT_THAT(findings_for(pairs, kMounting),
                HasFinding(Severity::Error, "imu_units", "degrees/s"));
}

TEST(HandEyeTest, ADiveThatDoesNotTurnSaysNothing) {
    auto pairs = random_motion(kMounting);
    for (RotationPair& pair : pairs) pair.vision_cam0 *= 0.01;

    EXPECT_TRUE(findings_for(pairs, kMounting.transpose()).empty());
}

std::string yaml_numbers(const Eigen::Isometry3d& T) {
    std::string text = "[";
    for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 4; ++column)
            text += std::to_string(T.matrix()(row, column)) + (row + column == 6 ? "]" : ", ");
    return text;
}

void write_mounting(const std::filesystem::path& yaml, const Eigen::Isometry3d& T_body_cam) {
    std::string text;
    {
        std::ifstream stream(yaml);
        text.assign(std::istreambuf_iterator<char>(stream), {});
    }
    const std::size_t begin = text.find('[');
    text.replace(begin, text.find(']') + 1 - begin, yaml_numbers(T_body_cam));
    std::ofstream(yaml) << text;
}

// The stereo calibration is right, but its rotation to the IMU is inverted; only motion shows it.
TEST(HandEyeTest, SharedDivesWithCamerasInvertedAgainstTheImuAreRefused) {
    for (const std::string name : {"tank", "euroc_mh01", "barge"}) {
        const auto original = shared_data(name);
        if (!std::filesystem::exists(original)) GTEST_SKIP() << "no shared data at " << original;
        const TemporaryFolder folder;
        std::filesystem::copy(
            original / "mav0", folder / "mav0", std::filesystem::copy_options::recursive);
        const types::Rig rig = Dive::open(original, folder / "scratch")->rig();
        const Eigen::Isometry3d T_wrong = rig.T_imu_cam0.inverse();
        write_mounting(folder / "mav0/cam0/sensor.yaml", T_wrong);
        write_mounting(folder / "mav0/cam1/sensor.yaml", T_wrong * rig.T_cam1_cam0().inverse());

        const auto dive = Dive::open(folder.path(), folder / "scratch");

        EXPECT_THAT(dive->findings(),
                    HasFinding(Severity::Error, "extrinsics_inverted", "T_BS looks inverted"))
            << name;
    }
}

TEST(HandEyeTest, SharedDiveWithSwappedImagesIsRefused) {
    const auto original = shared_data("tank");
    if (!std::filesystem::exists(original)) GTEST_SKIP() << "no shared data at " << original;
    const TemporaryFolder folder;
    std::filesystem::copy(
        original / "mav0", folder / "mav0", std::filesystem::copy_options::recursive);
    std::filesystem::rename(folder / "mav0/cam0/data", folder / "mav0/swap");
    std::filesystem::rename(folder / "mav0/cam1/data", folder / "mav0/cam0/data");
    std::filesystem::rename(folder / "mav0/swap", folder / "mav0/cam1/data");

    for (const char* recorded : {"with an IMU", "without one"}) {
        const auto dive = Dive::open(folder.path(), folder / "scratch");
        EXPECT_THAT(dive->findings(),
                    HasFinding(Severity::Error, "cameras_swapped", "mav0/cam0/data"))
            << recorded;
        std::filesystem::remove_all(folder / "mav0/imu0");
    }
}

}  // namespace
}  // namespace divemesh::dive
