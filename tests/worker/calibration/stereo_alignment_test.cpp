#include "worker/calibration/stereo_alignment.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "worker/base/rotation_vector.hpp"
#include "worker/camera/projection.hpp"
#include "worker/camera/rectified_lens.hpp"
#include "worker/camera/rectifier.hpp"

namespace divemesh::calibration {
namespace {

using Outcome = types::RigAlignment::Outcome;

constexpr double kDeg = std::numbers::pi / 180.0;
constexpr double kNoise_px = 0.2;

// Returns a rig as calibrated: lenses with distortion, cameras half a degree apart.
types::Rig stated_rig() {
    types::Rig rig;
    rig.cam0 = {640, 480, 489.6, 489.1, 320.9, 238.8};
    rig.cam0.distortion_coefficients = {-0.121, 0.031, 4e-4, -3e-4};
    rig.cam1 = {640, 480, 491.7, 491.2, 318.3, 241.4};
    rig.cam1.distortion_coefficients = {-0.118, 0.029, -3e-4, 5e-4};
    rig.T_imu_cam0.translation() = Eigen::Vector3d(-0.03, -0.06, 0.04);
    rig.T_imu_cam1 = rig.T_imu_cam0;
    rig.T_imu_cam1.translation().x() += 0.12;
    rig.T_imu_cam1.rotate(base::rotation_from_vector({0.003, 0.007, -0.004}));
    return rig;
}

// Returns the rig with its right camera turned about its own axes.
types::Rig knocked(const Eigen::Vector3d& degrees) {
    types::Rig rig = stated_rig();
    rig.T_imu_cam1.rotate(base::rotation_from_vector(kDeg * degrees));
    return rig;
}

// Pairs of a rough floor as a rig records them, rectified with the stated calibration.
class Pairs {
public:
    explicit Pairs(types::Rig rig) : rig_(std::move(rig)) {}

    types::StereoMatches matches(int num_pairs, int num_points, double outlier_share = 0.2) {
        types::StereoMatches found;
        for (int pair = 0; pair < num_pairs; ++pair)
            for (int i = 0; i < num_points; ++i) add(pair, outlier_share, found);
        return found;
    }
    // Moves the right image of each pair by a row offset of its own.
    void shake_rows(double amplitude_px) { shake_px_ = amplitude_px; }

private:
    double uniform(double from, double to) {
        return std::uniform_real_distribution<double>(from, to)(random_);
    }
    Eigen::Vector2d noise() {
        return kNoise_px * Eigen::Vector2d(normal_(random_), normal_(random_));
    }

    void add(int pair, double outlier_share, types::StereoMatches& found) {
        const Eigen::Vector2d left(uniform(0.0, 639.0), uniform(0.0, 479.0));
        const double depth_m = uniform(1.0, 3.0);
        const Eigen::Vector3d p_cam0 = depth_m * camera::unproject(rig_.cam0, left);
        auto right = camera::project(rig_.cam1, rig_.T_cam1_cam0() * p_cam0);
        if (!right || !camera::contains(rig_.cam1, *right)) return;
        *right += noise() + Eigen::Vector2d(0.0, shake_px_ * std::sin(2.0 * pair));
        types::StereoMatch match{pair,
                                 lenses_[0].rectified_px(rectified_, left),
                                 lenses_[1].rectified_px(rectified_, *right)};
        if (uniform(0.0, 1.0) < outlier_share)
            match.right_px = {uniform(0.0, 639.0), match.left_px.y() + uniform(-19.0, 19.0)};
        found.push_back(match);
    }

    types::Rig rig_;
    types::RectifiedRig rectified_ = camera::Rectifier(stated_rig()).rig();
    std::array<camera::RectifiedLens, 2> lenses_ = camera::rectified_lenses(stated_rig());
    double shake_px_ = 0.0;
    std::mt19937 random_{24};
    std::normal_distribution<double> normal_;
};

types::RigAlignment estimate(const types::StereoMatches& matches) {
    return estimate_rig_alignment(stated_rig(), camera::Rectifier(stated_rig()).rig(), matches);
}

// Returns the angle between the right camera as estimated and as it is, degrees.
double error_deg(const types::RigAlignment& found, const types::Rig& real) {
    const types::Rig rig = changed_rig(stated_rig(), found.change);
    return Eigen::AngleAxisd((rig.T_imu_cam1.inverse() * real.T_imu_cam1).linear()).angle() / kDeg;
}

TEST(StereoAlignmentTest, FindsTheRotationOfAKnockedCamera) {
    for (const Eigen::Vector3d& degrees : {Eigen::Vector3d(0.5, 0.0, 0.0),
                                           Eigen::Vector3d(-1.0, 0.0, 0.3),
                                           Eigen::Vector3d(0.06, 0.0, 0.0),
                                           Eigen::Vector3d(0.0, 0.0, 1.0),
                                           Eigen::Vector3d(0.3, 0.0, 0.2)}) {
        const types::Rig real = knocked(degrees);

        const types::RigAlignment found = estimate(Pairs(real).matches(12, 150));

        EXPECT_EQ(found.outcome, Outcome::Moved) << degrees.transpose();
        EXPECT_EQ(found.row_solver.num_failed + found.row_solver.num_still_moving, 0);
        EXPECT_LT(found.row_solver.final_cost, found.row_solver.initial_cost);
        EXPECT_LT(error_deg(found, real), 0.03) << degrees.transpose();
        EXPECT_NEAR(found.row_error_px, kNoise_px, 0.05) << degrees.transpose();
    }
}

TEST(StereoAlignmentTest, LeavesARightCalibrationAsStated) {
    const types::RigAlignment found = estimate(Pairs(stated_rig()).matches(12, 150));

    EXPECT_EQ(found.outcome, Outcome::AsStated);
    EXPECT_LT(found.row_shift_px, 0.05);
}

TEST(StereoAlignmentTest, KeepsTheBaselineAndTheLeftCamera) {
    types::RigChange change;
    change.values << 0.01, -0.005, 0.02, 0.004, -0.003, 0.001, 0.5;

    const types::Rig rig = changed_rig(stated_rig(), change);

    EXPECT_NEAR(rig.baseline_m(), stated_rig().baseline_m(), 1e-12);
    EXPECT_TRUE(rig.T_imu_cam0.isApprox(stated_rig().T_imu_cam0, 0.0));
    EXPECT_TRUE(changed_rig(stated_rig(), {}).T_imu_cam1.isApprox(stated_rig().T_imu_cam1, 1e-12));
}

TEST(StereoAlignmentTest, SaysNothingFromFewMatches) {
    const types::RigAlignment found = estimate(Pairs(knocked({0.5, 0.0, 0.0})).matches(2, 50));

    EXPECT_EQ(found.outcome, Outcome::Unknown);
}

TEST(StereoAlignmentTest, FindsNoPositionWherePairsDisagree) {
    Pairs pairs(stated_rig());
    pairs.shake_rows(5.0);

    EXPECT_EQ(estimate(pairs.matches(12, 150)).outcome, Outcome::Inconsistent);
}

TEST(StereoAlignmentTest, FindsNoPositionAmongWrongMatches) {
    EXPECT_EQ(estimate(Pairs(stated_rig()).matches(12, 150, 1.0)).outcome, Outcome::Inconsistent);
}

}  // namespace
}  // namespace divemesh::calibration
