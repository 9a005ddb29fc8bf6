#include "worker/estimation/marginalisation.hpp"

#include <gtest/gtest.h>

#include <array>
#include <ceres/covariance.h>
#include <ceres/manifold.h>
#include <ceres/solver.h>
#include <vector>

#include "worker/geometry/rotation_vector.hpp"
#include "worker/residuals/gyroscope_turn.hpp"
#include "worker/residuals/known_orientation.hpp"
#include "worker/residuals/random_walk.hpp"
#include "worker/residuals/vector_prior.hpp"

namespace divemesh::worker {
namespace {

constexpr std::size_t kNum = 5;
using Chain = std::array<Eigen::Vector3d, kNum>;

ceres::Problem::Options no_ownership() {
    ceres::Problem::Options options;
    options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    return options;
}

void measure(ceres::Problem& problem, Chain& x, std::size_t i) {
    const auto value = static_cast<double>(i);
    problem.AddResidualBlock(
        VectorPrior::create({{0.3 * value, 1.0 - value, std::sin(value)}, 0.5 + 0.1 * value}),
        nullptr,
        x[i].data());
}
void walk(ceres::Problem& problem, Chain& x, std::size_t i) {
    problem.AddResidualBlock(RandomWalk::create(0.2 + 0.05 * static_cast<double>(i)),
                             nullptr,
                             x[i].data(),
                             x[i + 1].data());
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
    ceres::Problem whole;
    for (std::size_t i = 0; i < kNum; ++i) measure(whole, all, i);
    for (std::size_t i = 0; i + 1 < kNum; ++i) walk(whole, all, i);
    solve(whole);

    LinearPrior prior;  // the oldest leave one by one
    for (std::size_t i = 0; i < 2; ++i) {
        ceres::Problem leaving;
        measure(leaving, rest, i);
        walk(leaving, rest, i);
        add_prior(leaving, prior);
        prior = marginalise(leaving, {rest[i].data()}, prior);
    }
    ceres::Problem window;
    for (std::size_t i = 2; i < kNum; ++i) measure(window, rest, i);
    for (std::size_t i = 2; i + 1 < kNum; ++i) walk(window, rest, i);
    add_prior(window, prior);
    solve(window);

    for (std::size_t i = 2; i < kNum; ++i) {
        EXPECT_LT((rest[i] - all[i]).norm(), 1e-9);
        EXPECT_LT((covariance(window, rest[i]) - covariance(whole, all[i])).norm(), 1e-9);
    }
}

// Two orientations and the gyroscope between them; the first leaves.
struct Turns {
    Eigen::Quaterniond q_world_ahrs = Eigen::Quaterniond::Identity();
    Eigen::Quaterniond q_first = rotation_from_vector({0.3, 0.1, -0.2});
    Eigen::Quaterniond q_second = rotation_from_vector({0.35, 0.05, 0.1});
    Eigen::Vector3d bias = Eigen::Vector3d(0.01, 0.0, -0.01);
    ceres::EigenQuaternionManifold rotation;

    void add_first(ceres::Problem& problem) {
        GyroscopeIntegral turn;
        turn.duration_s = 0.5;
        turn.q_from_to = rotation_from_vector({0.05, -0.06, 0.31});
        turn.d_rotation_d_bias = -0.5 * Eigen::Matrix3d::Identity();
        turn.sigma_rad = 0.01;
        problem.AddParameterBlock(q_first.coeffs().data(), 4, &rotation);
        problem.AddParameterBlock(q_second.coeffs().data(), 4, &rotation);
        problem.AddParameterBlock(q_world_ahrs.coeffs().data(), 4, &rotation);
        problem.SetParameterBlockConstant(q_world_ahrs.coeffs().data());
        problem.AddResidualBlock(GyroscopeTurn::create(turn),
                                 nullptr,
                                 q_first.coeffs().data(),
                                 q_second.coeffs().data(),
                                 bias.data());
        problem.AddResidualBlock(
            VectorPrior::create({Eigen::Vector3d::Zero(), 0.02}), nullptr, bias.data());
        add_orientation(problem, q_first, rotation_from_vector({0.31, 0.11, -0.21}));
    }
    void add_orientation(ceres::Problem& problem,
                         Eigen::Quaterniond& q,
                         const Eigen::Quaterniond& known) {
        problem.AddResidualBlock(KnownOrientation::create({known, 0.02}),
                                 nullptr,
                                 q_world_ahrs.coeffs().data(),
                                 q.coeffs().data());
    }
};

TEST(MarginalisationTest, AtItsMinimumANonlinearProblemKeepsItWhenAStateLeaves) {
    Turns all;
    Turns rest;
    const Eigen::Quaterniond seen = rotation_from_vector({0.34, 0.06, 0.12});
    ceres::Problem whole(no_ownership());
    all.add_first(whole);
    all.add_orientation(whole, all.q_second, seen);
    solve(whole);

    rest.q_first = all.q_first;
    rest.q_second = all.q_second;
    rest.bias = all.bias;
    ceres::Problem leaving(no_ownership());
    rest.add_first(leaving);
    const LinearPrior prior = marginalise(leaving, {rest.q_first.coeffs().data()}, {});
    rest.q_second = rest.q_second * rotation_from_vector({0.002, -0.001, 0.003});
    ceres::Problem window(no_ownership());
    window.AddParameterBlock(rest.q_second.coeffs().data(), 4, &rest.rotation);
    window.AddParameterBlock(rest.q_world_ahrs.coeffs().data(), 4, &rest.rotation);
    window.AddParameterBlock(rest.bias.data(), 3);
    window.SetParameterBlockConstant(rest.q_world_ahrs.coeffs().data());
    rest.add_orientation(window, rest.q_second, seen);
    add_prior(window, prior);
    solve(window);

    EXPECT_LT(rest.q_second.angularDistance(all.q_second), 1e-7);
    EXPECT_LT((rest.bias - all.bias).norm(), 1e-7);
}

TEST(MarginalisationTest, KeepsTheFirstEstimateOfWhatItHeldBefore) {
    Turns turns;
    ceres::Problem leaving(no_ownership());
    turns.add_first(leaving);
    const LinearPrior prior = marginalise(leaving, {turns.q_first.coeffs().data()}, {});
    const Eigen::Vector4d before = turns.q_second.coeffs();
    turns.q_second = turns.q_second * rotation_from_vector({0.1, -0.1, 0.05});

    ceres::Problem again(no_ownership());
    again.AddParameterBlock(turns.q_second.coeffs().data(), 4, &turns.rotation);
    again.AddParameterBlock(turns.bias.data(), 3);
    add_prior(again, prior);
    const LinearPrior once_more = marginalise(again, {}, prior);

    ASSERT_EQ(once_more.blocks.size(), prior.blocks.size());
    for (const auto& block : once_more.blocks)
        if (block.at.size() == 4) {
            EXPECT_LT((block.at - before).norm(), 1e-12);
        }
    EXPECT_LT((once_more.J.transpose() * once_more.J - prior.J.transpose() * prior.J).norm(),
              1e-6 * (prior.J.transpose() * prior.J).norm());
}

}  // namespace
}  // namespace divemesh::worker
