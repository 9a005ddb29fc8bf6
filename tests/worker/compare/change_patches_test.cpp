#include "worker/compare/change_patches.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <numbers>
#include <opencv2/core.hpp>
#include <random>

#include "tests/synthetic/small_reconstruction.hpp"
#include "tests/worker/compare/level_ground_map.hpp"

namespace divemesh::compare {
namespace {

constexpr double kCell_m = 0.03;
constexpr int kRows = 140;
constexpr int kColumns = 200;
constexpr float kNoise_m = 0.003F;
constexpr double kGround_m2 = kCell_m * kCell_m * kRows * kColumns;

// The error of a co-registration that rests on the same ground: tilts and a shift along z.
Vector6d registration_sigmas() {
    Vector6d sigmas = Vector6d::Zero();
    sigmas.head<2>().setConstant(5e-4);
    sigmas[5] = 2e-4;
    return sigmas;
}

// Returns level ground that rose by `rise_m` at each place, measured with noise and an error of the
// co-registration, in which changes beyond their level are found.
ChangeMap measured(const std::function<double(const Eigen::Vector2d&)>& rise_m,
                   const Vector6d& motion,
                   std::mt19937& random) {
    std::normal_distribution<float> noise(0.0F, kNoise_m);
    ChangeMap map =
        level_ground_map(kCell_m, kRows, kColumns, kNoise_m, independent(registration_sigmas()));
    for (int row = 0; row < kRows; ++row)
        for (int column = 0; column < kColumns; ++column) {
            const float change = static_cast<float>(rise_m(map.grid.center(row, column)) +
                                                    map.change_by_motion(row, column).dot(motion)) +
                                 noise(random);
            map.change_m.at<float>(row, column) = change;
            if (std::abs(change) > 1.96F * (kNoise_m + map.registration_m.at<float>(row, column)))
                map.state.at<std::uint8_t>(row, column) =
                    static_cast<std::uint8_t>(change > 0.0F ? CellState::Grown : CellState::Lost);
        }
    return map;
}

Changes gathered(ChangeMap map) {
    return gather_changes(map, {.least_area_m2 = 0.03, .core_area_m2 = 0.008, .margin_m = 0.06});
}

TEST(ChangePatchesTest, ATiltOfTheCoRegistrationHardlyWidensTheTotalsOfTheGroundAroundIt) {
    std::mt19937 random(1);
    const ChangeMap map = measured([](const auto&) { return 0.0; }, Vector6d::Zero(), random);
    const double as_one_signed_m3 =
        1.96 * kGround_m2 * cv::mean(map.registration_m)[0];  // if each cell erred upwards
    const Changes changes = gathered(map);
    for (const ChangeTotal* total : {&changes.grown, &changes.lost}) {
        EXPECT_LT(total->volume_m3.high - total->volume_m3.low, as_one_signed_m3 / 3.0);
        // The shift along z, of the half that rose or fell.
        EXPECT_GT(total->volume_m3.high, 0.4 * 1.96 * kGround_m2 * registration_sigmas()[5]);
    }
    EXPECT_LT(changes.rest_m3.high - changes.rest_m3.low, 2.0 * as_one_signed_m3 / 3.0);
}

// A colony of 9.4 l stands on the ground, to one side of the pivot, and a twentieth of the ground
// rose by less than its level of detection.
TEST(ChangePatchesTest, IntervalsHoldTheKnownVolumesOverManyErrorsOfTheCoRegistration) {
    constexpr int kDraws = 30;
    constexpr double kColony_m3 = std::numbers::pi * 0.3 * 0.3 * 0.1 / 3.0;
    constexpr double kFilm_m = 0.002;
    const auto film_m = [](const Eigen::Vector2d& p) {
        return p.x() < -0.45 * kCell_m * kColumns ? kFilm_m : 0.0;
    };
    const double film_m3 = 0.05 * kGround_m2 * kFilm_m;
    const auto rise_m = [&](const Eigen::Vector2d& p) {
        return film_m(p) + synthetic::cone(p.x() - 1.5, p.y() - 1.0, 0.3, 0.1);
    };
    std::mt19937 random(2);
    std::normal_distribution<double> normal;
    int num_patches = 0;
    int num_totals = 0;
    int num_rests = 0;
    const auto holds = [](const stats::Estimate& interval, double truth_m3) {
        return interval.low <= truth_m3 && truth_m3 <= interval.high;
    };
    for (int draw = 0; draw < kDraws; ++draw) {
        const Vector6d sigmas = registration_sigmas();
        const Vector6d motion = sigmas.unaryExpr([&](double s) { return s * normal(random); });
        const Changes changes = gathered(measured(rise_m, motion, random));
        ASSERT_EQ(changes.patches.size(), 1U);
        num_patches += holds(changes.patches[0].volume_m3, kColony_m3);
        num_totals += holds(changes.grown.volume_m3, kColony_m3 + film_m3);
        num_rests += holds(changes.rest_m3, film_m3);
    }
    // 95 % of 30 is 28.5; fewer than 26 occur in 1 % of all trials.
    EXPECT_GE(num_patches, 26);
    EXPECT_GE(num_totals, 26);
    EXPECT_GE(num_rests, 26);
}

}  // namespace
}  // namespace divemesh::compare
