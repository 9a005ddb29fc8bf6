#include <gtest/gtest.h>

#include "tests/synthetic/inertial_motion.hpp"
#include "tests/synthetic/numeric_jacobian.hpp"
#include "tests/synthetic/stereo_world.hpp"
#include "worker/calibration/lens_reprojection.hpp"
#include "worker/optimisation/residuals/gyro_rotation_cost.hpp"
#include "worker/optimisation/residuals/imu_preintegration_cost.hpp"
#include "worker/optimisation/residuals/misaligned_gyro_rotation_cost.hpp"
#include "worker/optimisation/residuals/orientation_prior.hpp"
#include "worker/optimisation/residuals/point_transfer.hpp"
#include "worker/optimisation/residuals/pressure_depth.hpp"
#include "worker/optimisation/residuals/random_walk.hpp"
#include "worker/optimisation/residuals/rotation_prior.hpp"
#include "worker/optimisation/residuals/stereo_reprojection.hpp"
#include "worker/optimisation/residuals/vector_prior.hpp"

namespace divemesh::optimisation {
namespace {

using synthetic::expect_true_jacobians;
using CostFunction = std::unique_ptr<ceres::CostFunction>;

std::vector<double> block(const Eigen::Quaterniond& q) { return {q.x(), q.y(), q.z(), q.w()}; }

double max_residual(const ceres::CostFunction& cost, std::vector<std::vector<double>> blocks) {
    EXPECT_EQ(blocks.size(), cost.parameter_block_sizes().size());
    std::vector<double*> parameters;
    for (auto& values : blocks) parameters.push_back(values.data());
    Eigen::VectorXd residuals(cost.num_residuals());
    EXPECT_TRUE(cost.Evaluate(parameters.data(), residuals.data(), nullptr));
    return residuals.cwiseAbs().maxCoeff();
}

TEST(StereoReprojectionTest, VanishesAtTheTruthAndHasTrueDerivatives) {
    const types::RectifiedRig rig = synthetic::rig();
    const Eigen::Isometry3d T_world_cam = synthetic::T_world_cam(20);
    const Eigen::Isometry3d T_world_imu = T_world_cam * rig.T_imu_cam.inverse();
    const Eigen::Vector3d p_cam(0.3, -0.2, 1.7);
    const Eigen::Vector3d p_world = T_world_cam * p_cam;
    const CostFunction cost(StereoReprojection::create(
        {rig, types::project_px(rig, p_cam), Eigen::Vector3d(0.3, 0.3, 0.2)}));
    const Eigen::Vector3d t = T_world_imu.translation();
    const std::vector<std::vector<double>> blocks = {
        block(Eigen::Quaterniond(T_world_imu.linear())),
        {t.x(), t.y(), t.z()},
        {p_world.x(), p_world.y(), p_world.z()}};

    EXPECT_LT(max_residual(*cost, blocks), 1e-9);
    expect_true_jacobians(*cost, blocks);
}

TEST(LensReprojectionTest, IsTheStereoReprojectionMovedByTheLensesAndHasTrueDerivatives) {
    const types::RectifiedRig rig = synthetic::rig();
    const Eigen::Isometry3d T_world_cam = synthetic::T_world_cam(20);
    const Eigen::Isometry3d T_world_imu = T_world_cam * rig.T_imu_cam.inverse();
    const Eigen::Vector3d p_cam(0.3, -0.2, 1.7);
    const Eigen::Vector3d p_world = T_world_cam * p_cam;
    calibration::LensReprojection reprojection;
    reprojection.shift_px.setRandom();
    Eigen::Matrix<double, calibration::LensReprojection::kNumChanges, 1> change;
    change.setLinSpaced(-0.2, 0.3);
    reprojection.by_readout_px_s = Eigen::Vector3d(40.0, -25.0, 3.0);
    constexpr double kReadout_s = 0.02;
    reprojection.stereo = {rig,
                           types::project_px(rig, p_cam) + reprojection.shift_px * change +
                               kReadout_s * reprojection.by_readout_px_s,
                           Eigen::Vector3d(0.3, 0.3, 0.2)};
    const CostFunction cost(calibration::LensReprojection::create(reprojection));
    const Eigen::Vector3d t = T_world_imu.translation();
    const std::vector<std::vector<double>> blocks = {
        block(Eigen::Quaterniond(T_world_imu.linear())),
        {t.x(), t.y(), t.z()},
        {p_world.x(), p_world.y(), p_world.z()},
        {change.data(), change.data() + change.size()},
        {kReadout_s}};

    EXPECT_LT(max_residual(*cost, blocks), 1e-9);
    expect_true_jacobians(*cost, blocks);
}

TEST(MisalignedGyroRotationCostTest, VanishesAtTheTruthAndHasTrueDerivatives) {
    MisalignedGyroRotationCost rotation;
    rotation.integral.duration_s = 0.5;
    rotation.integral.q_from_to = base::rotation_from_vector({0.1, -0.05, 0.2});
    rotation.integral.d_rotation_d_bias = -0.5 * Eigen::Matrix3d::Identity();
    rotation.integral.sigma_rad = 1e-3;
    rotation.d_rotation_d_time = Eigen::Vector3d(0.1, -0.2, 0.05);
    rotation.time_offset_s = 0.004;
    const Eigen::Quaterniond q_i = base::rotation_from_vector({0.4, 0.1, 0.9});
    const Eigen::Vector3d m(0.01, -0.02, 0.015);
    const Eigen::Quaterniond M = base::rotation_from_small_vector<double>(m);
    const Eigen::Quaterniond q_j = q_i * (M * rotation.integral.q_from_to * M.conjugate());
    const CostFunction cost(MisalignedGyroRotationCost::create(rotation));

    EXPECT_LT(
        max_residual(
            *cost,
            {block(q_i), block(q_j), {0, 0, 0}, {m.x(), m.y(), m.z()}, {0.004}, {0.0, 0.0, 0.0}}),
        1e-9);
    // Rates that are 3 % too large about one axis turn 3 % too far about it.
    rotation.integral.q_from_to = base::rotation_from_vector({0.0, 1.03 * 0.2, 0.0});
    const Eigen::Quaterniond q_too_far =
        q_i * (M * base::rotation_from_vector({0.0, 0.2, 0.0}) * M.conjugate());
    const CostFunction too_large(MisalignedGyroRotationCost::create(rotation));
    EXPECT_LT(max_residual(*too_large,
                           {block(q_i),
                            block(q_too_far),
                            {0, 0, 0},
                            {m.x(), m.y(), m.z()},
                            {0.004},
                            {0.0, 0.03 / 1.03, 0.0}}),
              1e-4);
    expect_true_jacobians(*cost,
                          {block(q_i),
                           block(q_j * base::rotation_from_vector({0.01, 0.0, 0.02})),
                           {0.01, -0.02, 0.005},
                           {0.02, 0.01, -0.01},
                           {0.006},
                           {0.01, -0.02, 0.03}});
}

TEST(PointTransferTest, VanishesAtTheTruthAndHasTrueDerivatives) {
    const types::RectifiedRig rig = synthetic::rig();
    const Eigen::Vector3d w(0.02, -0.03, 0.01);
    const Eigen::Vector3d t(0.05, -0.02, 0.03);
    const Eigen::Vector3d p_previous(-0.4, 0.3, 2.1);
    const CostFunction cost(PointTransfer::create(
        {rig,
         types::project_px(rig, p_previous),
         types::project_px(rig, base::rotation_from_vector(w) * p_previous + t),
         types::kFeatureSigma_px,
         types::kFeatureSigma_px}));

    EXPECT_LT(max_residual(*cost, {{w.x(), w.y(), w.z()}, {t.x(), t.y(), t.z()}}), 1e-9);
    expect_true_jacobians(*cost, {{0.03, -0.01, 0.0}, {0.06, -0.02, 0.05}});
}

TEST(RotationPriorTest, HasTrueDerivatives) {
    const CostFunction cost(
        RotationPrior::create(base::rotation_from_vector({0.1, 0.2, -0.1}), 0.01));

    EXPECT_LT(max_residual(*cost, {{0.1, 0.2, -0.1}}), 1e-9);
    expect_true_jacobians(*cost, {{0.11, 0.18, -0.13}});
}

TEST(OrientationPriorTest, HasTrueDerivatives) {
    const Eigen::Quaterniond q = base::rotation_from_vector({0.5, 1.2, -0.4});
    const Eigen::Quaterniond q_world_ahrs = base::rotation_from_vector({0.02, -0.03, 0.7});
    const CostFunction cost(OrientationPrior::create({q, 0.02}));

    EXPECT_LT(max_residual(*cost, {block(q_world_ahrs), block(q_world_ahrs * q)}), 1e-9);
    expect_true_jacobians(
        *cost,
        {block(q_world_ahrs),
         block(q_world_ahrs * q * base::rotation_from_vector({0.01, -0.02, 0.005}))});
}

TEST(GyroRotationCostTest, VanishesAtTheTruthAndHasTrueDerivatives) {
    imu::GyroscopeIntegral integral;
    integral.duration_s = 0.5;
    integral.q_from_to = base::rotation_from_vector({0.1, -0.05, 0.2});
    integral.d_rotation_d_bias = -0.5 * Eigen::Matrix3d::Identity();
    integral.sigma_rad = 1e-3;
    const Eigen::Quaterniond q_i = base::rotation_from_vector({0.4, 0.1, 0.9});
    const CostFunction cost(GyroRotationCost::create(integral));

    EXPECT_LT(max_residual(*cost, {block(q_i), block(q_i * integral.q_from_to), {0, 0, 0}}), 1e-9);
    expect_true_jacobians(
        *cost,
        {block(q_i),
         block(q_i * integral.q_from_to * base::rotation_from_vector({0.01, 0.0, 0.02})),
         {0.01, -0.02, 0.005}});
}

TEST(ImuPreintegrationCostTest, VanishesAtTheTruthAndHasTrueDerivatives) {
    const auto motion = [](double t_s) { return synthetic::T_world_imu_at(t_s); };
    const imu::ImuBias bias{{0.01, -0.02, 0.005}, {0.05, 0.1, -0.08}};
    const auto samples = synthetic::imu_along(motion, 0.0, 1.0, bias);
    const auto result =
        imu::preintegrate(samples, 203'000'000, 703'000'000, bias, types::ImuNoise{});
    ASSERT_TRUE(std::holds_alternative<imu::PreintegratedImu>(result));
    const CostFunction cost(ImuPreintegrationCost::create(std::get<imu::PreintegratedImu>(result)));
    const auto blocks_of = [&](double t_s) {
        const Eigen::Vector3d p = motion(t_s).translation();
        const Eigen::Vector3d v = synthetic::velocity(motion, t_s);
        return std::vector<std::vector<double>>{block(Eigen::Quaterniond(motion(t_s).linear())),
                                                {p.x(), p.y(), p.z()},
                                                {v.x(), v.y(), v.z()}};
    };
    auto blocks = blocks_of(0.203);
    blocks.push_back({0.01, -0.02, 0.005});
    blocks.push_back({0.05, 0.1, -0.08});
    for (const auto& values : blocks_of(0.703)) blocks.push_back(values);
    blocks.push_back({0.0, 0.0, -1.0});

    EXPECT_LT(max_residual(*cost, blocks), 1e-2);  // in sigmas
    blocks[3] = {0.013, -0.025, 0.004};
    blocks[4] = {0.1, 0.05, -0.02};
    blocks[6] = {0.2, 0.1, 0.0};
    blocks[8] = {0.1, 0.05, -0.99};
    expect_true_jacobians(*cost, blocks);
}

TEST(PressureDepthTest, VanishesAtTheTruthAndHasTrueDerivatives) {
    const CostFunction cost(PressureDepth::create({7.5, 0.02}));

    EXPECT_LT(max_residual(*cost, {{1.0, 2.0, -0.5}, {0.0, 0.0, -1.0}, {6.9}, {1.2}}), 1e-12);
    expect_true_jacobians(*cost, {{1.0, 2.0, -0.5}, {0.1, -0.2, -0.97}, {6.0}, {1.03}});
}

TEST(RandomWalkTest, HasTrueDerivatives) {
    const CostFunction cost(RandomWalk::create(0.5));

    EXPECT_LT(max_residual(*cost, {{0.1, 0.2, 0.3}, {0.1, 0.2, 0.3}}), 1e-12);
    expect_true_jacobians(*cost, {{1.0, -2.0, 3.0}, {0.5, 0.0, 0.1}});
}

TEST(VectorPriorTest, HasTrueDerivatives) {
    const CostFunction cost(VectorPrior::create({Eigen::Vector3d(0.1, 0.2, 0.3), 0.5}));

    EXPECT_LT(max_residual(*cost, {{0.1, 0.2, 0.3}}), 1e-12);
    expect_true_jacobians(*cost, {{1.0, -2.0, 3.0}});
}

}  // namespace
}  // namespace divemesh::optimisation
