#include "worker/calibration/range_problem.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <random>

#include "tests/synthetic/ideal_rig.hpp"
#include "worker/base/rotation_vector.hpp"

namespace divemesh::calibration {
namespace {

constexpr double kDeg = std::numbers::pi / 180.0;
constexpr double kNoise_px = 0.1;

const RangeUnknowns kNoChange = RangeUnknowns::Zero();
const RangeUnknowns kSigmas(0.0175, 1.0, 0.01, 0.01);

types::RectifiedRig rig() { return synthetic::ideal_rig(640, 480, 490.0); }

// Windows of a diver who swims over rough ground, rectified with a calibration whose right camera
// needs a yaw (rad) and another principal point (px).
class Windows {
public:
    Windows(double yaw_rad, double centre_px) : yaw_rad_(yaw_rad), centre_px_(centre_px) {}

    std::vector<RangeWindow> make(int num, double outlier_share = 0.1) {
        std::vector<RangeWindow> windows;
        for (int i = 0; i < num; ++i) windows.push_back(window(outlier_share));
        return windows;
    }

private:
    double uniform(double from, double to) {
        return std::uniform_real_distribution<double>(from, to)(random_);
    }
    double noise() { return kNoise_px * normal_(random_); }

    // Returns what the wrong calibration makes of the point.
    Eigen::Vector3d measured(const Eigen::Vector3d& p_cam) {
        const Eigen::Vector2d left = rig().pixel(p_cam);
        const Eigen::Vector3d right =
            base::rotation_from_vector({0.0, -yaw_rad_, 0.0}) *
            Eigen::Vector3d(p_cam - Eigen::Vector3d(rig().baseline_m, 0.0, 0.0));
        const double u_right = rig().pixel(right).x() + centre_px_;
        return {left.x() + noise(), left.y() + noise(), left.x() - u_right + noise()};
    }

    RangeWindow window(double outlier_share) {
        Eigen::Isometry3d T_after_before = Eigen::Isometry3d::Identity();
        T_after_before.linear() =
            base::rotation_from_vector(
                0.03 * Eigen::Vector3d(uniform(-1.0, 1.0), uniform(-1.0, 1.0), uniform(-1.0, 1.0)))
                .toRotationMatrix();
        T_after_before.translation() << uniform(-0.2, 0.2), uniform(-0.2, 0.2), uniform(-0.1, 0.1);
        RangeWindow result;
        result.T_after_before.translation() = 0.95 * T_after_before.translation();
        for (int i = 0; i < 100; ++i) {
            const Eigen::Vector3d p_before =
                rig().point_cam(uniform(60.0, 620.0), uniform(20.0, 460.0), uniform(1.0, 3.0));
            RangeMatch match{measured(p_before), measured(T_after_before * p_before)};
            if (uniform(0.0, 1.0) < outlier_share) match.after_px.x() += uniform(-4.0, 4.0);
            result.matches.push_back(match);
        }
        return result;
    }

    double yaw_rad_;
    double centre_px_;
    std::mt19937 random_{24};
    std::normal_distribution<double> normal_;
};

TEST(RangeProblemTest, TellsAYawFromAPrincipalPoint) {
    const RangeSolution turned =
        solve_ranges(rig(), Windows(0.5 * kDeg, 0.0).make(12), kNoChange, kSigmas);
    const RangeSolution shifted =
        solve_ranges(rig(), Windows(0.0, 1.5).make(12), kNoChange, kSigmas);

    EXPECT_TRUE(turned.outcome.converged()) << turned.outcome.message;
    EXPECT_LT(turned.outcome.final_cost, 0.5 * turned.outcome.initial_cost);
    EXPECT_NEAR(turned.values[0], 0.5 * kDeg, 0.03 * kDeg);
    EXPECT_NEAR(turned.values[1], 0.0, 0.3);
    EXPECT_NEAR(turned.bias_px, 490.0 * 0.5 * kDeg, 4.0 * turned.bias_sigma_px);
    EXPECT_NEAR(shifted.values[0], 0.0, 0.03 * kDeg);
    EXPECT_NEAR(shifted.values[1], 1.5, 0.3);
    EXPECT_NEAR(shifted.bias_px, -1.5, 4.0 * shifted.bias_sigma_px);
    EXPECT_LT(shifted.bias_sigma_px, 0.1);
}

TEST(RangeProblemTest, FindsNoBiasInARightCalibration) {
    const RangeSolution found = solve_ranges(rig(), Windows(0.0, 0.0).make(12), kNoChange, kSigmas);

    EXPECT_LT(std::abs(found.bias_px), 4.0 * found.bias_sigma_px);
    EXPECT_LT(found.bias_sigma_px, 0.1);
    EXPECT_NEAR(found.error_px, kNoise_px, 0.04);
}

// One window counts a quarter of one among four, so its sigma is four times that of four.
TEST(RangeProblemTest, FewWindowsTellLess) {
    const std::vector<RangeWindow> one = Windows(0.0, 0.0).make(1);
    const std::vector<RangeWindow> four(4, one[0]);
    const double sigma_of_four_px = solve_ranges(rig(), four, kNoChange, kSigmas).bias_sigma_px;
    const RangeSolution found = solve_ranges(rig(), one, kNoChange, kSigmas);
    EXPECT_GT(found.bias_sigma_px, 3.5 * sigma_of_four_px);
    EXPECT_LT(found.bias_sigma_px, 4.1 * sigma_of_four_px);
    EXPECT_LT(std::abs(found.bias_px), 3.0 * found.bias_sigma_px);
}

TEST(RangeProblemTest, FailsWhereAGuessIsNotFinite) {
    std::vector<RangeWindow> windows = Windows(0.0, 0.0).make(2);
    windows[1].T_after_before.translation().x() = std::numeric_limits<double>::quiet_NaN();

    EXPECT_TRUE(solve_ranges(rig(), windows, kNoChange, kSigmas).outcome.failed());
}

TEST(RangeProblemTest, KnowsNothingWithoutWindows) {
    const RangeSolution found = solve_ranges(rig(), {RangeWindow{}}, kNoChange, kSigmas);

    EXPECT_EQ(found.num_windows, 0);
    EXPECT_EQ(found.bias_px, 0.0);
}

}  // namespace
}  // namespace divemesh::calibration
