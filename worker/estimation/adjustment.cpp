#include "worker/estimation/adjustment.hpp"

#include <algorithm>
#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <cmath>

#include "worker/estimation/solver_progress.hpp"
#include "worker/residuals/gyroscope_turn.hpp"
#include "worker/residuals/known_orientation.hpp"
#include "worker/residuals/stereo_reprojection.hpp"
#include "worker/residuals/vector_prior.hpp"

namespace divemesh::worker {
namespace {

constexpr double kHuberReprojection = 1.5;  // in sigmas
constexpr double kHuberOrientation = 2.0;
constexpr double kLeastWalk = 1e-6;  // rad/s

ceres::Problem::Options problem_options() {
    ceres::Problem::Options options;
    options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    return options;
}

}  // namespace

BodyState BodyState::at(const Eigen::Isometry3d& T_world_imu, const Eigen::Vector3d& bias) {
    return {Eigen::Quaterniond(T_world_imu.linear()).normalized(), T_world_imu.translation(), bias};
}

Eigen::Isometry3d BodyState::T_world_imu() const {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = q_world_imu.normalized().toRotationMatrix();
    T.translation() = p_world_imu;
    return T;
}

struct Adjustment::Implementation {
    explicit Implementation(const RectifiedRig& rectified) : rig(rectified) {}

    double* q(BodyState& state) { return state.q_world_imu.coeffs().data(); }

    RectifiedRig rig;
    ceres::EigenQuaternionManifold rotation;
    ceres::HuberLoss reprojection_loss{kHuberReprojection};
    ceres::HuberLoss orientation_loss{kHuberOrientation};
    std::shared_ptr<ceres::ParameterBlockOrdering> ordering =
        std::make_shared<ceres::ParameterBlockOrdering>();
    ceres::Problem problem{problem_options()};
};

Adjustment::Adjustment(const RectifiedRig& rig)
    : implementation_(std::make_unique<Implementation>(rig)) {}
Adjustment::~Adjustment() = default;

void Adjustment::add_state(BodyState& state, bool fixed) {
    auto& own = *implementation_;
    own.problem.AddParameterBlock(own.q(state), 4, &own.rotation);
    own.problem.AddParameterBlock(state.p_world_imu.data(), 3);
    own.ordering->AddElementToGroup(own.q(state), 1);
    own.ordering->AddElementToGroup(state.p_world_imu.data(), 1);
    if (!fixed) return;
    own.problem.SetParameterBlockConstant(own.q(state));
    own.problem.SetParameterBlockConstant(state.p_world_imu.data());
}

void Adjustment::add_observation(BodyState& state,
                                 Eigen::Vector3d& p_world,
                                 const Eigen::Vector3d& measured_px,
                                 const Eigen::Vector3d& sigma_px) {
    auto& own = *implementation_;
    own.problem.AddResidualBlock(StereoReprojection::create({own.rig, measured_px, sigma_px}),
                                 &own.reprojection_loss,
                                 own.q(state),
                                 state.p_world_imu.data(),
                                 p_world.data());
    own.ordering->AddElementToGroup(p_world.data(), 0);
}

void Adjustment::add_turn(BodyState& from,
                          BodyState& to,
                          const GyroscopeIntegral& turn,
                          double random_walk) {
    auto& own = *implementation_;
    const double walk = std::max(kLeastWalk, random_walk * std::sqrt(turn.duration_s));
    own.problem.AddResidualBlock(GyroscopeTurn::create({turn, walk}),
                                 nullptr,
                                 own.q(from),
                                 own.q(to),
                                 from.gyroscope_bias.data(),
                                 to.gyroscope_bias.data());
    own.ordering->AddElementToGroup(from.gyroscope_bias.data(), 1);
    own.ordering->AddElementToGroup(to.gyroscope_bias.data(), 1);
}

void Adjustment::add_bias(BodyState& state, const Eigen::Vector3d& known, double sigma) {
    auto& own = *implementation_;
    own.problem.AddResidualBlock(
        VectorPrior::create({known, sigma}), nullptr, state.gyroscope_bias.data());
    own.ordering->AddElementToGroup(state.gyroscope_bias.data(), 1);
}

void Adjustment::fix_bias(BodyState& state) {
    implementation_->problem.SetParameterBlockConstant(state.gyroscope_bias.data());
}

void Adjustment::add_orientation(BodyState& state,
                                 const Eigen::Quaterniond& q_world_imu,
                                 double sigma_rad) {
    auto& own = *implementation_;
    own.problem.AddResidualBlock(
        KnownOrientation::create({q_world_imu, sigma_rad}), &own.orientation_loss, own.q(state));
}

void Adjustment::solve(Size size,
                       int max_iterations,
                       const ProgressCallback& progress,
                       const Progress& at) {
    auto& own = *implementation_;
    ceres::Solver::Options options;
    options.linear_solver_type = size == Size::Window ? ceres::DENSE_SCHUR : ceres::SPARSE_SCHUR;
    options.linear_solver_ordering = own.ordering;
    options.max_num_iterations = max_iterations;
    options.function_tolerance = size == Size::Window ? 1e-4 : 1e-5;
    options.logging_type = ceres::SILENT;
    options.num_threads = 1;
    SolverProgress callback(progress, at);
    options.callbacks.push_back(&callback);
    ceres::Solver::Summary summary;
    ceres::Solve(options, &own.problem, &summary);
    callback.rethrow();
}

}  // namespace divemesh::worker
