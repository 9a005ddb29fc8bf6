#include "worker/optimisation/levenberg_marquardt.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <map>

#include "tests/synthetic/inertial_motion.hpp"
#include "tests/synthetic/pose_near.hpp"
#include "tests/synthetic/sensor_recording.hpp"
#include "worker/optimisation/inertial_factors.hpp"

namespace divemesh::optimisation {
namespace {

constexpr int kNumKeyframes = 7;
constexpr int kStep = 4;  // frames of 0.1 s between keyframes
const imu::ImuBias kBias{{0.004, -0.006, 0.003}, {0.03, -0.02, 0.04}};

// A sliding window on the path of stereo_world.hpp, with noise, some gross errors, and poses that
// are off by millimetres.
struct NoisyWindow {
    NoisyWindow() {
        recording.its_rig.imu_noise = types::ImuNoise{2e-4, 2e-5, 2e-3, 2e-4};
        recording.its_imu = synthetic::imu_along(
            synthetic::T_world_imu_at, 0.0, 0.1 * kStep * kNumKeyframes, kBias);
        const types::RectifiedRig rig = synthetic::rig();
        synthetic::World world(0.03 * kStep * kNumKeyframes, 0.05, 3);
        for (int k = 0; k < kNumKeyframes; ++k) {
            const Eigen::Isometry3d T_world_cam = synthetic::T_world_cam(kStep * k);
            Eigen::Isometry3d T_off = T_world_cam;
            if (k > 0) T_off.translate(0.004 * Eigen::Vector3d(world.normal(), world.normal(), 0));
            keyframes.push_back({k, 100'000'000LL * kStep * k, T_off});
            states.push_back(BodyState::at(T_off * rig.T_imu_cam.inverse(), {}));
            for (const types::Feature& feature : world.see(T_world_cam, kStep * k, 0.3)) {
                points.try_emplace(feature.id, T_off * types::point_cam(rig, feature));
                seen[feature.id].emplace_back(k, types::measurement_px(feature));
            }
        }
    }

    template <typename Solve>
    void adjust(const Solve& solve) {
        BundleAdjustment bundle_adjustment(synthetic::rig());
        for (std::size_t k = 0; k < states.size(); ++k)
            bundle_adjustment.add_state(states[k], k == 0);
        for (const auto& [id, observations] : seen)
            for (const auto& [k, measured] : observations)
                if (observations.size() > 1)
                    bundle_adjustment.add_observation(states[static_cast<std::size_t>(k)],
                                                      points.at(id),
                                                      measured,
                                                      types::kFeatureSigma_px);
        add_inertial_factors(
            bundle_adjustment, imu::InertialPrior(recording, {}), keyframes, states, reference);
        solve(bundle_adjustment);
    }

    synthetic::SensorRecording recording;
    std::vector<types::Keyframe> keyframes;
    std::vector<BodyState> states;
    std::map<std::int64_t, Eigen::Vector3d> points;
    std::map<std::int64_t, std::vector<std::pair<int, Eigen::Vector3d>>> seen;
    WorldReference reference;
};

TEST(LevenbergMarquardtTest, EndsWhereCeresEnds) {
    NoisyWindow own;
    own.adjust([](BundleAdjustment& bundle_adjustment) {
        for (int i = 0; i < 4; ++i) bundle_adjustment.solve_dense(10);
    });
    NoisyWindow theirs;
    theirs.adjust([](BundleAdjustment& bundle_adjustment) {
        for (int i = 0; i < 4; ++i) bundle_adjustment.solve_sparse(30, base::ignore_progress, {});
    });

    ASSERT_FALSE(own.states.empty());
    for (std::size_t k = 0; k < own.states.size(); ++k) {
        EXPECT_THAT(own.states[k].T_world_imu(),
                    synthetic::IsPoseWithin(theirs.states[k].T_world_imu(), 1e-3, 1e-5));
        EXPECT_LT((own.states[k].velocity_world - theirs.states[k].velocity_world).norm(), 1e-4);
        EXPECT_LT((own.states[k].bias.gyroscope - theirs.states[k].bias.gyroscope).norm(), 1e-5);
    }
    EXPECT_LT(
        (own.reference.gravity_direction_world - theirs.reference.gravity_direction_world).norm(),
        1e-4);
}

TEST(LevenbergMarquardtTest, FindsTheWayWithinAFewMillimetres) {
    NoisyWindow window;
    window.adjust([](BundleAdjustment& bundle_adjustment) { bundle_adjustment.solve_dense(6); });
    for (int k = 0; k < kNumKeyframes; ++k)
        EXPECT_THAT(window.states[static_cast<std::size_t>(k)].T_world_imu(),
                    synthetic::IsPoseWithin(
                        synthetic::T_world_cam(kStep * k) * synthetic::rig().T_imu_cam.inverse(),
                        0.2,
                        0.006));
}

TEST(LevenbergMarquardtTest, SaysThatItConverged) {
    types::SolverOutcome outcome;
    NoisyWindow window;
    window.adjust(
        [&](BundleAdjustment& bundle_adjustment) { outcome = bundle_adjustment.solve_dense(50); });
    EXPECT_EQ(outcome.termination, types::SolverOutcome::Termination::Converged) << outcome.message;
    EXPECT_LT(outcome.num_iterations, 50);
    EXPECT_LT(outcome.final_cost, 0.5 * outcome.initial_cost);
    EXPECT_LT(outcome.last_decrease, 1e-3);
}

TEST(LevenbergMarquardtTest, SaysThatItStoppedWhileTheCostWasStillFalling) {
    types::SolverOutcome outcome;
    NoisyWindow window;
    window.adjust(
        [&](BundleAdjustment& bundle_adjustment) { outcome = bundle_adjustment.solve_dense(1); });
    EXPECT_EQ(outcome.termination, types::SolverOutcome::Termination::StoppedAtLimit);
    EXPECT_EQ(outcome.num_iterations, 1);
    EXPECT_LT(outcome.final_cost, outcome.initial_cost);
    EXPECT_GT(outcome.last_decrease, 0.01);
}

TEST(LevenbergMarquardtTest, SaysThatItFailedWhereTheCostIsNotANumber) {
    types::SolverOutcome outcome;
    NoisyWindow window;
    window.states[3].p_world_imu.x() = std::numeric_limits<double>::quiet_NaN();
    window.adjust(
        [&](BundleAdjustment& bundle_adjustment) { outcome = bundle_adjustment.solve_dense(5); });
    EXPECT_TRUE(outcome.failed());
    EXPECT_EQ(outcome.num_iterations, 0);
}

// One plus the square of an unknown, with a derivative that is right or has the wrong sign.
class OnePlusSquare : public ceres::SizedCostFunction<2, 1> {
public:
    explicit OnePlusSquare(double slope) : slope_(slope) {}
    bool Evaluate(const double* const* x, double* residuals, double** jacobians) const override {
        residuals[0] = x[0][0];
        residuals[1] = 1.0;
        if (jacobians != nullptr && jacobians[0] != nullptr) {
            jacobians[0][0] = slope_;
            jacobians[0][1] = 0.0;
        }
        return true;
    }

private:
    double slope_;
};

types::SolverOutcome solve_square(double& x, double slope) {
    FactorGraph graph(1.0);
    graph.add_factor(std::make_unique<OnePlusSquare>(slope), nullptr, {&x});
    return levenberg_marquardt(graph, 6, 1e-6);
}

TEST(LevenbergMarquardtTest, SaysThatItFailedWhereNoStepLowersTheCost) {
    double x = 2.0;
    const types::SolverOutcome outcome = solve_square(x, -1.0);
    EXPECT_TRUE(outcome.failed()) << outcome.message;
    EXPECT_DOUBLE_EQ(outcome.final_cost, outcome.initial_cost);
    EXPECT_DOUBLE_EQ(x, 2.0);
}

TEST(LevenbergMarquardtTest, SaysThatItConvergedWhereItBegan) {
    double x = 1e-12;
    const types::SolverOutcome outcome = solve_square(x, 1.0);
    EXPECT_EQ(outcome.termination, types::SolverOutcome::Termination::Converged) << outcome.message;
    EXPECT_DOUBLE_EQ(outcome.final_cost, outcome.initial_cost);
}

TEST(LevenbergMarquardtTest, GivesTheSameBitsAgain) {
    const auto solve = [](BundleAdjustment& bundle_adjustment) {
        bundle_adjustment.solve_dense(6);
    };
    NoisyWindow once;
    once.adjust(solve);
    NoisyWindow again;
    again.adjust(solve);
    EXPECT_EQ(once.states.back().T_world_imu().matrix(),
              again.states.back().T_world_imu().matrix());
}

}  // namespace
}  // namespace divemesh::optimisation
