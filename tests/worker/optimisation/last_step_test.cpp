#include <gtest/gtest.h>

#include <ceres/autodiff_cost_function.h>
#include <ceres/problem.h>
#include <cmath>

#include "tests/synthetic/stereo_world.hpp"
#include "tests/synthetic/tracked_dive.hpp"
#include "worker/optimisation/bundle_adjustment.hpp"
#include "worker/optimisation/ceres_outcome.hpp"

namespace divemesh::optimisation {
namespace {

// A residual in standard deviations of a value that was measured as 0.
struct Measured {
    double sigma;
    template <typename T>
    bool operator()(const T* value, T* residual) const {
        residual[0] = value[0] / sigma;
        return true;
    }
};

TEST(CeresOutcomeTest, TheLastStepIsInStandardDeviations) {
    constexpr double kSigma = 0.02;
    for (const double sigmas : {0.5, 3.0}) {
        double value = sigmas * kSigma;
        ceres::Problem problem;
        problem.AddResidualBlock(
            new ceres::AutoDiffCostFunction<Measured, 1, 1>(new Measured{kSigma}), nullptr, &value);
        ceres::Solver::Options options;
        options.max_num_iterations = 1;
        options.logging_type = ceres::SILENT;
        ceres::Solver::Summary summary;
        ceres::Solve(options, &problem, &summary);
        EXPECT_NEAR(outcome_of(summary).last_step_sigmas, sigmas, 0.01 * sigmas);
    }
}

TEST(BundleAdjustmentTest, KnowsHowItsLastStepMovedThePositions) {
    const types::Track track = synthetic::tracked_dive(6);
    std::vector<BodyState> states;
    for (const types::Keyframe& keyframe : track.keyframes)
        states.push_back(
            BodyState::at(keyframe.T_world_cam * track.rig.T_imu_cam.inverse(), imu::ImuBias{}));
    for (std::size_t k = 1; k < states.size(); ++k)
        states[k].p_world_imu += 0.01 * Eigen::Vector3d(std::sin(k), std::cos(k), 0.5);
    std::vector<types::Landmark> landmarks = track.landmarks;
    BundleAdjustment bundle_adjustment(track.rig);
    for (std::size_t k = 0; k < states.size(); ++k) bundle_adjustment.add_state(states[k], k == 0);
    for (types::Landmark& landmark : landmarks)
        for (const types::LandmarkObservation& seen : landmark.observations)
            bundle_adjustment.add_observation(states[static_cast<std::size_t>(seen.keyframe)],
                                              landmark.p_world,
                                              {seen.u_px, seen.v_px, seen.disparity_px},
                                              types::kFeatureSigma_px);
    const std::vector<BodyState> before = states;
    bundle_adjustment.solve_sparse(1, base::ignore_progress, {});
    ASSERT_EQ(bundle_adjustment.last_moves_m().size(), states.size());
    for (std::size_t k = 0; k < states.size(); ++k) {
        const Eigen::Vector3d move_m = states[k].p_world_imu - before[k].p_world_imu;
        EXPECT_EQ(bundle_adjustment.last_moves_m()[k], move_m) << k;
        EXPECT_EQ(move_m.norm() > 0.005, k > 0) << k;
    }
}

}  // namespace
}  // namespace divemesh::optimisation
