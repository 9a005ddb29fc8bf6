#include <gtest/gtest.h>

#include <cmath>

#include "tests/worker/board_calibration/synthetic_boards.hpp"
#include "worker/board_calibration/calibrate_rig.hpp"
#include "worker/board_calibration/length_error.hpp"

namespace divemesh::board_calibration {
namespace {

constexpr int kNumDraws = 20;

double baseline_m(const RigParameters& rig) {
    return isometry_of(rig.T_cam1_cam0).translation().norm();
}

// Over many draws of noise and poses parameters are within three of their standard deviations in at
// least 95 %, and the scale is right.
void expect_honest(types::Distortion distortion) {
    const boards::Board board = known_checkerboard();
    const RigParameters truth = known_rig(distortion);
    int num_within = 0;
    double worst_scale = 0.0;
    double squares = 0.0;
    for (int seed = 0; seed < kNumDraws; ++seed) {
        std::mt19937_64 random(static_cast<std::uint64_t>(100 + seed));
        const double sigma_px = 0.1 + 0.2 * seed / (kNumDraws - 1);
        const auto views =
            drawn_views(truth, board, drawn_poses(board, 90, random), sigma_px, random);
        const RigEstimate estimate =
            calibrate_rig(board, views, {1280, 960}, {1280, 960}, distortion, {});
        ASSERT_EQ(estimate.failure, "");
        EXPECT_NEAR(estimate.sigma_px / sigma_px, 1.0, 0.05);
        const RigVector error = estimate.rig.vector() - truth.vector();
        for (int i = 0; i < kRigSize; ++i) {
            const double sigmas = error[i] / std::sqrt(estimate.covariance(i, i));
            num_within += std::abs(sigmas) <= 3.0 ? 1 : 0;
            squares += sigmas * sigmas;
        }
        worst_scale =
            std::max(worst_scale, std::abs(baseline_m(estimate.rig) / baseline_m(truth) - 1.0));
    }
    EXPECT_GE(num_within, 0.95 * kNumDraws * kRigSize);
    EXPECT_LT(worst_scale, 5e-4);
    std::printf("within 3 sigma: %d of %d; rms %.2f sigma; scale off by at most %.4f %%\n",
                num_within,
                kNumDraws * kRigSize,
                std::sqrt(squares / (kNumDraws * kRigSize)),
                100.0 * worst_scale);
}

TEST(RigStatisticsTest, ErrorsOfARadialTangentialRigAreWhatItsCovarianceSays) {
    expect_honest(types::Distortion::RadialTangential);
}

TEST(RigStatisticsTest, ErrorsOfAFisheyeRigAreWhatItsCovarianceSays) {
    expect_honest(types::Distortion::Equidistant);
}

}  // namespace
}  // namespace divemesh::board_calibration
