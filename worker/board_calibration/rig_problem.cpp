#include "worker/board_calibration/rig_problem.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <ceres/ceres.h>
#include <ceres/normal_prior.h>

#include "worker/board_calibration/board_reprojection.hpp"
#include "worker/camera/lens_model.hpp"
#include "worker/camera/projection.hpp"

namespace divemesh::board_calibration {
namespace {

constexpr int kMaxIterations = 60;           // 10 to 20 are common
constexpr int kMaxIterationsOfPriors = 300;  // such coefficients move slowly
constexpr double kBehind_px = 1e4;           // error of a corner behind its camera
constexpr double kMinFocal_px = 10.0;        // below this an image is all of a hemisphere
// Standard deviations of k4 k5 k6 of a rational lens, and of k1 k2 of an omnidirectional one.
constexpr double kRationalPrior = 0.5;
constexpr double kOmnidirectionalPrior = 0.2;
constexpr double kMinReciprocal = 1e-13;  // smallest pivot over largest of a determined rig

using PoseMatrix = Eigen::Matrix<double, kPoseSize, kPoseSize>;
using RigPoseMatrix = Eigen::Matrix<double, Eigen::Dynamic, kPoseSize>;
using ByLens = Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor>;

ceres::Solver::Options solver_options(int max_iterations) {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_SCHUR;
    options.max_num_iterations = max_iterations;
    options.function_tolerance = 1e-9;
    options.parameter_tolerance = 1e-10;
    options.num_threads = 1;  // the order of sums is part of the result
    options.logging_type = ceres::SILENT;
    return options;
}

// Keeps focal lengths and leading coefficients in their ranges.
void bound(ceres::Problem& problem, const LensKind& kind, LensValues& lens) {
    double* block = lens.data();
    if (!problem.HasParameterBlock(block)) return;
    for (const int focal : {0, 1}) problem.SetParameterLowerBound(block, focal, kMinFocal_px);
    int index = kPinholeSize;
    for (const auto& coefficient : camera::lens_model(kind.distortion).leading) {
        problem.SetParameterLowerBound(block, index, coefficient.min);
        problem.SetParameterUpperBound(block, index++, coefficient.max);
    }
}

// Returns the weights of priors at 0, px: of coefficients that corners alone do not determine,
// because others of the model bend the image nearly alike. 0: none.
LensValues prior_weights_px(types::Distortion distortion, double sigma_px) {
    LensValues weights = {};
    double* const k = weights.data() + kPinholeSize;
    if (distortion == types::Distortion::Rational) k[5] = k[6] = k[7] = sigma_px / kRationalPrior;
    if (distortion == types::Distortion::Omnidirectional)
        k[1] = k[2] = sigma_px / kOmnidirectionalPrior;
    return weights;
}

bool has_priors(const LensKind& kind) {
    return prior_weights_px(kind.distortion, 1.0) != LensValues{};
}

void add_priors(ceres::Problem& problem, const LensKind& kind, double sigma_px, LensValues& lens) {
    if (!has_priors(kind) || !problem.HasParameterBlock(lens.data())) return;
    const LensValues weights_px = prior_weights_px(kind.distortion, sigma_px);
    const int num = kind.num_values();
    const Eigen::MatrixXd weights =
        Eigen::Map<const Eigen::VectorXd>(weights_px.data(), num).asDiagonal();
    problem.AddResidualBlock(
        new ceres::NormalPrior(weights, Eigen::VectorXd::Zero(num)), nullptr, lens.data());
}

// The derivatives of the errors of a view by the rig and by its own pose.
struct ViewJacobian {
    Eigen::MatrixXd by_rig;
    Eigen::Matrix<double, Eigen::Dynamic, kPoseSize> by_pose;
    Eigen::VectorXd errors_px;
};

ViewJacobian jacobian_of(const boards::Board& board,
                         const RigParameters& rig,
                         const PosedView& posed) {
    const auto num_left = static_cast<Eigen::Index>(posed.view.left.size());
    const auto num = num_left + static_cast<Eigen::Index>(posed.view.right.size());
    ViewJacobian all;
    all.by_rig.setZero(2 * num, rig.size());
    all.by_pose.setZero(2 * num, kPoseSize);
    all.errors_px.setZero(2 * num);
    ByLens by_lens;
    Eigen::Matrix<double, 2, kPoseSize, Eigen::RowMajor> by_stereo;
    Eigen::Matrix<double, 2, kPoseSize, Eigen::RowMajor> by_pose;
    Eigen::Vector2d error;
    const int num_values0 = rig.kind0.num_values();
    const int num_values1 = rig.kind1.num_values();
    for (Eigen::Index i = 0; i < num; ++i) {
        const bool is_right = i >= num_left;
        const boards::BoardCorner& corner =
            is_right ? posed.view.right[static_cast<std::size_t>(i - num_left)]
                     : posed.view.left[static_cast<std::size_t>(i)];
        by_lens.resize(2, is_right ? num_values1 : num_values0);
        const Eigen::Vector3d p_board = board.corner_m(corner.corner);
        bool valid = false;
        if (is_right) {
            const auto cost = right_board_reprojection(rig.kind1.distortion, p_board, corner.pixel);
            const double* blocks[] = {
                rig.lens1.data(), rig.T_cam1_cam0.data(), posed.T_cam0_board.data()};
            double* jacobians[] = {by_lens.data(), by_stereo.data(), by_pose.data()};
            valid = cost->Evaluate(blocks, error.data(), jacobians);
        } else {
            const auto cost = left_board_reprojection(rig.kind0.distortion, p_board, corner.pixel);
            const double* blocks[] = {rig.lens0.data(), posed.T_cam0_board.data()};
            double* jacobians[] = {by_lens.data(), by_pose.data()};
            valid = cost->Evaluate(blocks, error.data(), jacobians);
        }
        if (!valid) continue;
        all.errors_px.segment<2>(2 * i) = error;
        all.by_pose.middleRows<2>(2 * i) = by_pose;
        all.by_rig.block(2 * i, is_right ? num_values0 : 0, 2, by_lens.cols()) = by_lens;
        if (is_right) all.by_rig.block<2, kPoseSize>(2 * i, num_values0 + num_values1) = by_stereo;
    }
    return all;
}

// Returns the diagonal of the priors' normal equations.
RigVector information_of_priors(const RigParameters& rig, double sigma_px) {
    RigParameters weights = rig;
    weights.lens0 = prior_weights_px(rig.kind0.distortion, sigma_px);
    weights.lens1 = prior_weights_px(rig.kind1.distortion, sigma_px);
    weights.T_cam1_cam0 = {};
    return weights.vector().cwiseAbs2();
}

// The normal equations of the rig with the poses eliminated, and the sums of what each view pulls.
struct ReducedRig {
    RigCovariance information;  // with the priors
    RigCovariance pulls;
    RigVector priors;  // their share of the diagonal
};

ReducedRig reduced(const boards::Board& board,
                   double sigma_px,
                   const RigParameters& rig,
                   const std::vector<PosedView>& views) {
    ReducedRig sum;
    sum.priors = information_of_priors(rig, sigma_px);
    sum.information = sum.priors.asDiagonal();
    sum.pulls.setZero(rig.size(), rig.size());
    for (const PosedView& posed : views) {
        const ViewJacobian J = jacobian_of(board, rig, posed);
        const PoseMatrix of_pose = J.by_pose.transpose() * J.by_pose;
        const RigPoseMatrix between = J.by_rig.transpose() * J.by_pose;
        const Eigen::LDLT<PoseMatrix> factor(of_pose);
        const RigPoseMatrix gain = factor.solve(between.transpose()).transpose();
        sum.information += J.by_rig.transpose() * J.by_rig - gain * between.transpose();
        const RigVector pull =
            J.by_rig.transpose() * J.errors_px - gain * (J.by_pose.transpose() * J.errors_px);
        sum.pulls += pull * pull.transpose();
    }
    return sum;
}

}  // namespace

SolveOutcome solve_rig(const boards::Board& board,
                       double huber_px,
                       RigParameters& rig,
                       std::vector<PosedView>& views) {
    ceres::Problem::Options problem_options;
    problem_options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ceres::HuberLoss loss(huber_px);
    ceres::Problem problem(problem_options);
    auto* ordering = new ceres::ParameterBlockOrdering;
    for (PosedView& posed : views) {
        double* pose = posed.T_cam0_board.data();
        for (const boards::BoardCorner& corner : posed.view.left)
            problem.AddResidualBlock(
                left_board_reprojection(
                    rig.kind0.distortion, board.corner_m(corner.corner), corner.pixel)
                    .release(),
                &loss,
                rig.lens0.data(),
                pose);
        for (const boards::BoardCorner& corner : posed.view.right)
            problem.AddResidualBlock(
                right_board_reprojection(
                    rig.kind1.distortion, board.corner_m(corner.corner), corner.pixel)
                    .release(),
                &loss,
                rig.lens1.data(),
                rig.T_cam1_cam0.data(),
                pose);
        ordering->AddElementToGroup(pose, 0);
    }
    for (double* block : {rig.lens0.data(), rig.lens1.data(), rig.T_cam1_cam0.data()})
        if (problem.HasParameterBlock(block)) ordering->AddElementToGroup(block, 1);
    const double sigma_px = huber_px / kHuberSigmas;
    add_priors(problem, rig.kind0, sigma_px, rig.lens0);
    add_priors(problem, rig.kind1, sigma_px, rig.lens1);
    bound(problem, rig.kind0, rig.lens0);
    bound(problem, rig.kind1, rig.lens1);
    ceres::Solver::Options options =
        solver_options(has_priors(rig.kind0) ? kMaxIterationsOfPriors : kMaxIterations);
    options.linear_solver_ordering.reset(ordering);
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    return {summary.termination_type == ceres::CONVERGENCE, summary.message};
}

std::vector<CornerError> corner_errors(const boards::Board& board,
                                       const RigParameters& rig,
                                       const std::vector<PosedView>& views) {
    std::vector<CornerError> errors;
    const types::Camera cam0 = rig.cam0();
    const types::Camera cam1 = rig.cam1();
    const Eigen::Isometry3d T_cam1_cam0 = isometry_of(rig.T_cam1_cam0);
    for (std::size_t i = 0; i < views.size(); ++i) {
        const Eigen::Isometry3d T_cam0_board = isometry_of(views[i].T_cam0_board);
        const auto add = [&](const types::Camera& camera,
                             const Eigen::Isometry3d& T_cam_board,
                             const boards::BoardCorners& corners,
                             bool is_right) {
            for (const boards::BoardCorner& corner : corners) {
                const auto pixel =
                    camera::project(camera, T_cam_board * board.corner_m(corner.corner));
                errors.push_back({i,
                                  is_right,
                                  corner.corner,
                                  corner.pixel,
                                  pixel ? Eigen::Vector2d(*pixel - corner.pixel)
                                        : Eigen::Vector2d(kBehind_px, kBehind_px)});
            }
        };
        add(cam0, T_cam0_board, views[i].view.left, false);
        add(cam1, T_cam1_cam0 * T_cam0_board, views[i].view.right, true);
    }
    return errors;
}

std::optional<RigCovariance> rig_covariance(const boards::Board& board,
                                            double sigma_px,
                                            const RigParameters& rig,
                                            const std::vector<PosedView>& views) {
    const ReducedRig sum = reduced(board, sigma_px, rig, views);
    // Scaled to a diagonal of ones: pixels, radians and metres then compare.
    const RigVector scale = sum.information.diagonal().cwiseMax(0.0).cwiseSqrt();
    if (!(scale.minCoeff() > 0.0)) return std::nullopt;
    const RigVector unscale = scale.cwiseInverse();
    const RigCovariance scaled = unscale.asDiagonal() * sum.information * unscale.asDiagonal();
    const Eigen::LDLT<RigCovariance> factor(scaled);
    if (factor.info() != Eigen::Success || !factor.isPositive()) return std::nullopt;
    const RigVector pivots = factor.vectorD();
    if (!(pivots.minCoeff() > kMinReciprocal * pivots.maxCoeff())) return std::nullopt;
    const RigCovariance inverse = unscale.asDiagonal() *
                                  factor.solve(RigCovariance::Identity(rig.size(), rig.size())) *
                                  unscale.asDiagonal();
    const RigCovariance by_noise = sigma_px * sigma_px * inverse;
    const RigCovariance by_views = inverse * sum.pulls * inverse;
    const double num_determined =
        static_cast<double>(rig.size()) - inverse.diagonal().dot(sum.priors);
    const double disagreement =
        by_views.diagonal().cwiseQuotient(by_noise.diagonal()).sum() / num_determined;
    return RigCovariance(std::max(1.0, disagreement) * by_noise);
}

}  // namespace divemesh::board_calibration
