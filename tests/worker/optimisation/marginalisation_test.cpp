#include "worker/optimisation/marginalisation.hpp"

#include <gtest/gtest.h>

#include <array>
#include <ceres/covariance.h>
#include <ceres/manifold.h>
#include <ceres/solver.h>
#include <map>
#include <memory>
#include <vector>

#include "tests/synthetic/stereo_world.hpp"
#include "worker/base/rotation_vector.hpp"
#include "worker/optimisation/bundle_adjustment.hpp"
#include "worker/optimisation/residuals/gyro_rotation_cost.hpp"
#include "worker/optimisation/residuals/orientation_prior.hpp"
#include "worker/optimisation/residuals/random_walk.hpp"
#include "worker/optimisation/residuals/vector_prior.hpp"

namespace divemesh::optimisation {
namespace {

constexpr std::size_t kNum = 5;
using Chain = std::array<Eigen::Vector3d, kNum>;

void add(FactorGraph& graph, ceres::CostFunction* cost, const std::vector<double*>& blocks) {
    graph.add_factor(std::unique_ptr<ceres::CostFunction>(cost), nullptr, blocks);
}
void measure(FactorGraph& graph, Chain& x, std::size_t i) {
    const auto value = static_cast<double>(i);
    add(graph,
        VectorPrior::create({{0.3 * value, 1.0 - value, std::sin(value)}, 0.5 + 0.1 * value}),
        {x[i].data()});
}
void walk(FactorGraph& graph, Chain& x, std::size_t i) {
    add(graph,
        RandomWalk::create(0.2 + 0.05 * static_cast<double>(i)),
        {x[i].data(), x[i + 1].data()});
}

void solve(ceres::Problem& problem) {
    ceres::Solver::Options options;
    options.function_tolerance = 1e-16;
    options.gradient_tolerance = 1e-14;
    options.parameter_tolerance = 1e-14;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
}

Eigen::Matrix3d covariance(ceres::Problem& problem, Eigen::Vector3d& x) {
    ceres::Covariance estimate({});
    EXPECT_TRUE(estimate.Compute(std::vector<const double*>{x.data()}, &problem));
    Eigen::Matrix<double, 3, 3, Eigen::RowMajor> result;
    EXPECT_TRUE(estimate.GetCovarianceBlock(x.data(), x.data(), result.data()));
    return result;
}

TEST(MarginalisationTest, ALinearProblemWithoutItsOldestHasTheEstimateAndCovarianceOfTheWhole) {
    Chain all;
    Chain rest;
    all.fill(Eigen::Vector3d(7.0, -3.0, 2.0));
    rest = all;
    FactorGraph whole_graph(1.0);
    for (std::size_t i = 0; i < kNum; ++i) measure(whole_graph, all, i);
    for (std::size_t i = 0; i + 1 < kNum; ++i) walk(whole_graph, all, i);
    const auto whole = whole_graph.problem();
    solve(*whole);

    LinearPrior prior;  // the oldest blocks leave one by one
    for (std::size_t i = 0; i < 2; ++i) {
        FactorGraph leaving(1.0);
        measure(leaving, rest, i);
        walk(leaving, rest, i);
        add_prior(leaving, prior);
        prior = marginalise(leaving, {rest[i].data()});
    }
    FactorGraph window_graph(1.0);
    for (std::size_t i = 2; i < kNum; ++i) measure(window_graph, rest, i);
    for (std::size_t i = 2; i + 1 < kNum; ++i) walk(window_graph, rest, i);
    add_prior(window_graph, prior);
    const auto window = window_graph.problem();
    solve(*window);

    for (std::size_t i = 2; i < kNum; ++i) {
        EXPECT_LT((rest[i] - all[i]).norm(), 1e-9);
        EXPECT_LT((covariance(*window, rest[i]) - covariance(*whole, all[i])).norm(), 1e-9);
    }
}

// Two orientations connected by the gyroscope; the first one leaves.
struct Turns {
    Eigen::Quaterniond q_world_ahrs = Eigen::Quaterniond::Identity();
    Eigen::Quaterniond q_first = base::rotation_from_vector({0.3, 0.1, -0.2});
    Eigen::Quaterniond q_second = base::rotation_from_vector({0.35, 0.05, 0.1});
    Eigen::Vector3d bias = Eigen::Vector3d(0.01, 0.0, -0.01);
    ceres::EigenQuaternionManifold rotation;

    void add_first(FactorGraph& graph) {
        imu::GyroscopeIntegral gyro_rotation;
        gyro_rotation.duration_s = 0.5;
        gyro_rotation.q_from_to = base::rotation_from_vector({0.05, -0.06, 0.31});
        gyro_rotation.d_rotation_d_bias = -0.5 * Eigen::Matrix3d::Identity();
        gyro_rotation.sigma_rad = 0.01;
        graph.add_block(q_first.coeffs().data(), 4, &rotation);
        add_second(graph);
        add(graph,
            GyroRotationCost::create(gyro_rotation),
            {q_first.coeffs().data(), q_second.coeffs().data(), bias.data()});
        add(graph, VectorPrior::create({Eigen::Vector3d::Zero(), 0.02}), {bias.data()});
        add_orientation(graph, q_first, base::rotation_from_vector({0.31, 0.11, -0.21}));
    }
    void add_second(FactorGraph& graph) {
        graph.add_block(q_second.coeffs().data(), 4, &rotation);
        graph.add_block(q_world_ahrs.coeffs().data(), 4, &rotation);
        graph.fix(q_world_ahrs.coeffs().data());
    }
    void add_orientation(FactorGraph& graph,
                         Eigen::Quaterniond& q,
                         const Eigen::Quaterniond& known) {
        add(graph,
            OrientationPrior::create({known, 0.02}),
            {q_world_ahrs.coeffs().data(), q.coeffs().data()});
    }
};

TEST(MarginalisationTest, AtItsMinimumANonlinearProblemKeepsItWhenAStateLeaves) {
    Turns all;
    Turns rest;
    const Eigen::Quaterniond seen = base::rotation_from_vector({0.34, 0.06, 0.12});
    FactorGraph whole(1.0);
    all.add_first(whole);
    all.add_orientation(whole, all.q_second, seen);
    solve(*whole.problem());

    rest.q_first = all.q_first;
    rest.q_second = all.q_second;
    rest.bias = all.bias;
    FactorGraph leaving(1.0);
    rest.add_first(leaving);
    const LinearPrior prior = marginalise(leaving, {rest.q_first.coeffs().data()});
    rest.q_second = rest.q_second * base::rotation_from_vector({0.002, -0.001, 0.003});
    FactorGraph window(1.0);
    rest.add_second(window);
    rest.add_orientation(window, rest.q_second, seen);
    add_prior(window, prior);
    solve(*window.problem());

    EXPECT_LT(rest.q_second.angularDistance(all.q_second), 1e-7);
    EXPECT_LT((rest.bias - all.bias).norm(), 1e-7);
}

TEST(MarginalisationTest, KeepsTheFirstEstimateOfWhatItHeldBefore) {
    Turns rotations;
    FactorGraph leaving(1.0);
    rotations.add_first(leaving);
    const LinearPrior prior = marginalise(leaving, {rotations.q_first.coeffs().data()});
    const Eigen::Vector4d before = rotations.q_second.coeffs();
    rotations.q_second = rotations.q_second * base::rotation_from_vector({0.1, -0.1, 0.05});

    FactorGraph again(1.0);
    rotations.add_second(again);
    add_prior(again, prior);
    const LinearPrior once_more = marginalise(again, {});

    ASSERT_EQ(once_more.blocks.size(), prior.blocks.size());
    int num_rotations = 0;
    for (const auto& block : once_more.blocks) {
        if (block.at.size() != 4) continue;
        ++num_rotations;
        EXPECT_LT((block.at - before).norm(), 1e-12);
    }
    EXPECT_EQ(num_rotations, 1);
    EXPECT_LT((once_more.J.transpose() * once_more.J - prior.J.transpose() * prior.J).norm(),
              1e-6 * (prior.J.transpose() * prior.J).norm());
    EXPECT_LT((once_more.J.transpose() * once_more.r_at - prior.J.transpose() * prior.r_at).norm(),
              1e-6 * (prior.J.transpose() * prior.r_at).norm());
}

// Three keyframes that observe some points each; the first one leaves with its points.
TEST(MarginalisationTest, LandmarksLeaveAsTheyWouldByTheSchurComplementOfCeres) {
    const types::RectifiedRig rig = synthetic::rig();
    synthetic::World world(1.0, 0.0, 5);
    std::vector<BodyState> states;
    std::map<std::int64_t, Eigen::Vector3d> points;
    ceres::EigenQuaternionManifold rotation;
    FactorGraph graph(1.5);
    std::map<std::int64_t, std::vector<std::pair<std::size_t, Eigen::Vector3d>>> seen;
    for (std::size_t k = 0; k < 3; ++k) {
        const auto T_world_cam = synthetic::T_world_cam(8.0 * static_cast<double>(k));
        states.push_back(BodyState::at(T_world_cam * rig.T_imu_cam.inverse(), {}));
        for (const types::Feature& feature : world.see(T_world_cam, 0, 0.3)) {
            if (feature.id % 8 != 0) continue;
            points.try_emplace(feature.id, T_world_cam * types::point_cam(rig, feature));
            seen[feature.id].emplace_back(k, types::measurement_px(feature));
        }
    }
    for (std::size_t k = 0; k < 3; ++k) {
        graph.add_block(states[k].q_world_imu.coeffs().data(), 4, &rotation);
        graph.add_block(states[k].p_world_imu.data(), 3);
    }
    for (auto& [id, observations] : seen)
        for (const auto& [k, measured] : observations)
            if (observations.size() > 1)
                graph.add_observation({rig, measured, types::kFeatureSigma_px},
                                      states[k].q_world_imu.coeffs().data(),
                                      states[k].p_world_imu.data(),
                                      points.at(id));
    graph.fix(states[0].q_world_imu.coeffs().data());
    graph.fix(states[0].p_world_imu.data());
    const auto problem = graph.problem();
    solve(*problem);

    const LinearPrior prior = marginalise(graph, {});
    ASSERT_EQ(prior.blocks.size(), 4U);
    const Eigen::MatrixXd own = (prior.J.transpose() * prior.J).inverse();
    ceres::Covariance::Options options;
    options.apply_loss_function = true;
    ceres::Covariance covariance(options);
    ASSERT_TRUE(covariance.Compute(
        std::vector<const double*>{states[1].p_world_imu.data(), states[2].p_world_imu.data()},
        problem.get()));
    for (std::size_t k = 1; k < 3; ++k) {
        Eigen::Matrix<double, 3, 3, Eigen::RowMajor> theirs;
        covariance.GetCovarianceBlock(
            states[k].p_world_imu.data(), states[k].p_world_imu.data(), theirs.data());
        const auto at = static_cast<Eigen::Index>(6 * (k - 1) + 3);
        EXPECT_LT((own.block<3, 3>(at, at) - theirs).norm(), 1e-4 * theirs.norm());
    }
}

}  // namespace
}  // namespace divemesh::optimisation
