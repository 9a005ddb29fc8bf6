#include "worker/odometry/refine_pose.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <iterator>
#include <limits>
#include <vector>

#include "worker/base/rotation_vector.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::odometry {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Matrix36d = Eigen::Matrix<double, 3, 6>;

constexpr int kMaxIterations = 10;
constexpr double kHuber = 2.0;       // sigmas of a whole measurement (u, v, disparity)
constexpr double kConverged = 1e-6;  // rad and m
constexpr double kMinDepth_m = 1e-3;
constexpr double kFirstDamping = 1e-6;  // of the diagonal
constexpr double kMoreDamping = 100.0;
constexpr double kTolerance = 1e-3;  // of the cost, which also changes with the covariances

// The normal equations of one step, rotation first.
struct NormalEquations {
    Matrix6d H = Matrix6d::Zero();
    Vector6d g = Vector6d::Zero();
    double cost = 0.0;
};

// Returns d h / d p.
Eigen::Matrix3d projection_jacobian(const types::RectifiedRig& rig, const Eigen::Vector3d& p) {
    const double scale = rig.focal_px / p.z();
    Eigen::Matrix3d by_point;
    by_point << scale, 0.0, -scale * p.x() / p.z(),  //
        0.0, scale, -scale * p.y() / p.z(),          //
        0.0, 0.0, -scale * rig.baseline_m / p.z();
    return by_point;
}

// Returns d p / d m of a triangulated point.
Eigen::Matrix3d point_by_measurement(const types::RectifiedRig& rig,
                                     const Eigen::Vector3d& p,
                                     double disparity_px) {
    const double scale = p.z() / rig.focal_px;
    Eigen::Matrix3d by_measurement;
    by_measurement << scale, 0.0, -p.x() / disparity_px,  //
        0.0, scale, -p.y() / disparity_px,                //
        0.0, 0.0, -p.z() / disparity_px;
    return by_measurement;
}

// Returns false if the point would lie behind the camera.
bool add_pair(const types::RectifiedRig& rig,
              const PointPair& pair,
              const Eigen::Isometry3d& T_current_previous,
              NormalEquations& equations) {
    const Eigen::Vector3d turned = T_current_previous.linear() * pair.p_previous;
    const Eigen::Vector3d moved = turned + T_current_previous.translation();
    if (moved.z() < kMinDepth_m) return false;
    const Eigen::Vector3d error = types::project_px(rig, moved) - pair.current_px;
    const Eigen::Matrix3d by_point = projection_jacobian(rig, moved);
    const Eigen::Matrix3d J = by_point * T_current_previous.linear() *
                              point_by_measurement(rig, pair.p_previous, pair.previous_px.z()) *
                              pair.previous_sigma_px.asDiagonal();
    Eigen::Matrix3d covariance = J * J.transpose();
    covariance.diagonal() += pair.current_sigma_px.cwiseAbs2();
    const Eigen::Matrix3d information = covariance.inverse();
    const double squared = error.dot(information * error);
    const double size = std::sqrt(squared);
    const double weight = size <= kHuber ? 1.0 : kHuber / size;
    equations.cost += size <= kHuber ? squared : 2.0 * kHuber * size - kHuber * kHuber;
    Matrix36d by_motion;
    by_motion << -by_point * base::cross_matrix(turned), by_point;
    const Eigen::Matrix<double, 6, 3> weighted = weight * by_motion.transpose() * information;
    equations.H.noalias() += weighted * by_motion;
    equations.g.noalias() += weighted * error;
    return true;
}

void add_known_rotation(const types::KnownRotation& known,
                        const Eigen::Isometry3d& T_current_previous,
                        NormalEquations& equations) {
    const Eigen::Vector3d error = base::vector_from_rotation(
        Eigen::Quaterniond(T_current_previous.linear()) * known.q.conjugate());
    const double information = 1.0 / (known.sigma_rad * known.sigma_rad);
    equations.cost += information * error.squaredNorm();
    equations.H.topLeftCorner<3, 3>().diagonal().array() += information;
    equations.g.head<3>() += information * error;
}

// Returns infinite cost if a point lies behind the camera.
NormalEquations linearise(const types::RectifiedRig& rig,
                          const PointPairs& pairs,
                          const std::optional<types::KnownRotation>& known,
                          const Eigen::Isometry3d& T_current_previous) {
    NormalEquations equations;
    for (const PointPair& pair : pairs) {
        if (add_pair(rig, pair, T_current_previous, equations)) continue;
        equations.cost = std::numeric_limits<double>::infinity();
        return equations;
    }
    if (known) add_known_rotation(*known, T_current_previous, equations);
    return equations;
}

Eigen::Isometry3d moved_by(const Vector6d& step, const Eigen::Isometry3d& T) {
    Eigen::Isometry3d result = T;
    result.linear() = (base::rotation_from_vector(step.head<3>()) * Eigen::Quaterniond(T.linear()))
                          .normalized()
                          .toRotationMatrix();
    result.translation() += step.tail<3>();
    return result;
}

}  // namespace

RefinedPose refine_pose(const types::RectifiedRig& rig,
                        const PointPairs& pairs,
                        const MotionGuess& guess) {
    using Termination = types::SolverOutcome::Termination;
    RefinedPose refined{guess.T_current_previous, {}};
    types::SolverOutcome& outcome = refined.outcome;
    NormalEquations here = linearise(rig, pairs, guess.rotation, refined.T_current_previous);
    outcome.initial_cost = here.cost;
    outcome.final_cost = here.cost;
    outcome.message = "a point lies behind the camera";
    double damping = kFirstDamping;
    for (int iteration = 0; iteration < kMaxIterations && std::isfinite(here.cost); ++iteration) {
        outcome.termination = Termination::StoppedAtLimit;
        outcome.message = "the last step was still large";
        Matrix6d damped = here.H;
        damped.diagonal() *= 1.0 + damping;
        const Eigen::LDLT<Matrix6d> factor(damped);
        if (factor.info() != Eigen::Success || !factor.isPositive()) {
            outcome.termination = Termination::Failed;
            outcome.message = "the pairs do not determine the motion";
            break;
        }
        ++outcome.num_iterations;
        const Vector6d step = factor.solve(-here.g);
        const Eigen::Isometry3d T = moved_by(step, refined.T_current_previous);
        const NormalEquations there = linearise(rig, pairs, guess.rotation, T);
        if (there.cost <= (1.0 + kTolerance) * here.cost) {
            refined.T_current_previous = T;
            outcome.last_decrease = (here.cost - there.cost) / here.cost;
            outcome.last_step_sigmas = std::sqrt(step.dot(here.H * step) / 6.0);
            here = there;
            damping /= kMoreDamping;
        } else {
            damping *= kMoreDamping;
        }
        if (step.cwiseAbs().maxCoeff() < kConverged) {
            outcome.termination = Termination::Converged;
            outcome.message = "the last step was small";
            break;
        }
    }
    if (!outcome.failed()) outcome.final_cost = here.cost;
    return refined;
}

Matrix6d motion_covariance(const types::RectifiedRig& rig,
                           const PointPairs& pairs,
                           const MotionGuess& motion) {
    return linearise(rig, pairs, motion.rotation, motion.T_current_previous)
        .H.ldlt()
        .solve(Matrix6d::Identity());
}

double max_sigma_rad(const types::RectifiedRig& rig,
                     const PointPairs& pairs,
                     const MotionGuess& motion) {
    constexpr double kUnknown_rad = std::numeric_limits<double>::infinity();
    if (pairs.empty()) return kUnknown_rad;
    std::vector<double> depths_m;
    depths_m.reserve(pairs.size());
    for (const PointPair& pair : pairs) depths_m.push_back(pair.p_previous.z());
    Vector6d scale = Vector6d::Ones();
    scale.tail<3>().setConstant(stats::upper_median(std::move(depths_m)));
    const NormalEquations equations =
        linearise(rig, pairs, motion.rotation, motion.T_current_previous);
    const Matrix6d information = scale.asDiagonal() * equations.H * scale.asDiagonal();
    const double min_information =
        Eigen::SelfAdjointEigenSolver<Matrix6d>(information, Eigen::EigenvaluesOnly)
            .eigenvalues()(0);
    return min_information > 0.0 ? 1.0 / std::sqrt(min_information) : kUnknown_rad;
}

}  // namespace divemesh::odometry
