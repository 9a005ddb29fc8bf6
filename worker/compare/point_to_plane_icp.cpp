#include "worker/compare/point_to_plane_icp.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

#include "worker/base/parallel.hpp"
#include "worker/base/rotation_vector.hpp"
#include "worker/stats/median.hpp"
#include "worker/stats/robust.hpp"

namespace divemesh::compare {
namespace {

using Matrix7d = Eigen::Matrix<double, 7, 7>;
using Vector7d = Eigen::Matrix<double, 7, 1>;

constexpr float kMinNormalCosine = 0.5F;  // between the normals of partners
constexpr double kMinScale_m = 5e-4;
constexpr double kSettled_m = 1e-5;
constexpr std::size_t kMinPartners = 100;
constexpr double kMinScaleShare = 1e-6;  // of a scale's effect, what no motion of b explains

struct Partner {
    bool found = false;
    Eigen::Vector3d p;  // of b, in a's frame
    Eigen::Vector3d normal;
    double residual_m = 0.0;  // of b outside a
    double sigma_m = 0.0;     // of both
};

double sigma_of(const SurfacePoints& surface, std::size_t i) {
    return surface.sigma_m.empty() ? 0.0 : static_cast<double>(surface.sigma_m[i]);
}

// `nearest_points`: in, the points of a nearest to b's in the last iteration; out, those of this
// one.
std::vector<Partner> find_partners(const SurfacePoints& a,
                                   const SurfacePoints& b,
                                   const Eigen::Isometry3d& T_a_b,
                                   const IcpOptions& options,
                                   double reach_m,
                                   std::vector<std::optional<std::uint32_t>>& nearest_points) {
    std::vector<Partner> partners(b.points.size());
    constexpr std::size_t kSlice = 1024;
    base::for_each_index(
        options.num_threads, (partners.size() + kSlice - 1) / kSlice, [&](std::size_t slice) {
            for (std::size_t i = slice * kSlice;
                 i < std::min(partners.size(), (slice + 1) * kSlice);
                 ++i) {
                Partner& partner = partners[i];
                partner.p = T_a_b * b.points[i].cast<double>();
                auto& nearest = nearest_points[i];
                nearest =
                    a.grid.nearest(partner.p.cast<float>(), static_cast<float>(reach_m), nearest);
                if (!nearest) continue;
                const Eigen::Vector3f normal =
                    (T_a_b.linear() * b.normals[i].cast<double>()).cast<float>();
                if (a.normals[*nearest].dot(normal) < kMinNormalCosine) continue;
                partner.found = true;
                partner.normal = a.normals[*nearest].cast<double>();
                partner.residual_m =
                    partner.normal.dot(partner.p - a.points[*nearest].cast<double>());
                partner.sigma_m = std::hypot(sigma_of(a, *nearest), sigma_of(b, i));
            }
        });
    return partners;
}

// Returns the robust standard deviation of the residuals.
double robust_scale(const std::vector<Partner>& partners) {
    std::vector<double> sizes;
    for (const Partner& partner : partners)
        if (partner.found) sizes.push_back(std::abs(partner.residual_m));
    return sizes.empty() ? 0.0
                         : std::max(kMinScale_m,
                                    stats::kSigmasPerMad * stats::upper_median(std::move(sizes)));
}

// Normal equations of rotation, shift and scale, in this order. ICP solves for the pose alone.
struct NormalEquations {
    Matrix7d information = Matrix7d::Zero();
    Vector7d gradient = Vector7d::Zero();

    void add(const Vector7d& row, double weight, double residual_m) {
        information += weight * row * row.transpose();
        gradient += weight * residual_m * row;
    }
};

struct Fit : NormalEquations {
    std::map<std::array<int, 3>, NormalEquations> patches;
    double squares = 0.0;
    double weights = 0.0;
    std::size_t num_used = 0;

    Matrix6d pose_information() const { return information.topLeftCorner<6, 6>(); }
    Vector6d pose_gradient() const { return gradient.head<6>(); }
};

Fit linearise(const std::vector<Partner>& partners,
              double scale_m,
              const Eigen::Vector3d& pivot,
              double patch_m) {
    Fit fit;
    for (const Partner& partner : partners) {
        if (!partner.found) continue;
        const double biweight = stats::tukey_weight(
            partner.residual_m, stats::kTukey * std::hypot(scale_m, partner.sigma_m));
        if (biweight == 0.0) continue;
        const double variance = scale_m * scale_m + partner.sigma_m * partner.sigma_m;
        const double weight = biweight * scale_m * scale_m / variance;
        const Eigen::Vector3d lever_m = partner.p - pivot;
        Vector7d row;
        row << motion_along(lever_m, partner.normal), lever_m.dot(partner.normal);
        fit.add(row, weight, partner.residual_m);
        fit.squares += weight * partner.residual_m * partner.residual_m;
        fit.weights += weight;
        fit.num_used += biweight > 0.25;
        std::array<int, 3> patch{};
        for (int axis = 0; axis < 3; ++axis)
            patch[static_cast<std::size_t>(axis)] =
                static_cast<int>(std::floor(partner.p[axis] / patch_m));
        patch[2] = 0;  // columns: the same views saw what hangs over the same ground
        fit.patches[patch].add(row, weight, partner.residual_m);
    }
    return fit;
}

// Keeps directions that the surface does not determine (e.g. a plane's rotation about its normal).
Vector6d solve(const Fit& fit) {
    const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(fit.pose_information());
    const Vector6d& values = solver.eigenvalues();
    Vector6d inverse;
    for (int i = 0; i < 6; ++i) inverse[i] = values[i] > 1e-9 * values[5] ? 1.0 / values[i] : 0.0;
    return -(solver.eigenvectors() *
             (inverse.asDiagonal() * (solver.eigenvectors().transpose() * fit.pose_gradient())));
}

// Solves for the rotation about the vertical and the shift only.
Vector6d solve_upright(const Fit& fit) {
    Vector6d step = Vector6d::Zero();
    step.tail<4>() = -fit.pose_information().bottomRightCorner<4, 4>().ldlt().solve(
        fit.pose_gradient().tail<4>());
    return step;
}

// Returns the inverse of the information; where the surface determines nothing, a large value.
Matrix6d inverse_information(const Fit& fit) {
    const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(fit.pose_information());
    Vector6d inverse;
    for (int i = 0; i < 6; ++i)
        inverse[i] = 1.0 / std::max(solver.eigenvalues()[i], 1e-9 * solver.eigenvalues()[5]);
    return solver.eigenvectors() * inverse.asDiagonal() * solver.eigenvectors().transpose();
}

Matrix6d sandwich(const Fit& fit) {
    const Matrix6d bread = inverse_information(fit);
    Matrix6d meat = Matrix6d::Zero();
    for (const auto& [place, patch] : fit.patches)
        meat += patch.gradient.head<6>() * patch.gradient.head<6>().transpose();
    const auto num = static_cast<double>(fit.patches.size());
    return num / std::max(1.0, num - 6.0) * bread * meat * bread;
}

// One Gauss-Newton step for the scale together with the pose.
struct ScaleStep {
    ScaleDifference scale;  // sigma: sandwich estimator
    Vector6d pose;
};

std::optional<ScaleStep> solve_with_scale(const Fit& fit) {
    const Matrix6d inverse = inverse_information(fit);
    Vector7d direction;  // of the solution: the scale, and the pose that goes with it
    direction << -inverse * fit.information.topRightCorner<6, 1>(), 1.0;
    const double left = direction.dot(fit.information.col(6));  // Schur complement
    if (!(left > kMinScaleShare * fit.information(6, 6))) return std::nullopt;
    const double value = direction.dot(fit.gradient) / left;
    double squares = 0.0;
    for (const auto& [place, patch] : fit.patches) {
        const Vector7d unexplained = patch.gradient - value * (patch.information * direction);
        const double part = direction.dot(unexplained) / left;
        squares += part * part;
    }
    const auto num = static_cast<double>(fit.patches.size());
    return ScaleStep{
        {value, std::sqrt(num / std::max(1.0, num - 7.0) * squares), std::sqrt(left / fit.weights)},
        -inverse * (fit.pose_gradient() - value * fit.information.topRightCorner<6, 1>())};
}

// Returns the size of the step, RMS of its standard deviations: those of the patches, and at least
// those of independent errors.
double step_sigmas(const Vector6d& step,
                   const Fit& fit,
                   const Matrix6d& covariance,
                   double scale_m) {
    const Matrix6d whole = covariance + scale_m * scale_m * inverse_information(fit);
    return std::sqrt(step.dot(whole.ldlt().solve(step)) / 6.0);
}

Eigen::Isometry3d moved(const Eigen::Isometry3d& T_a_b,
                        const Vector6d& step,
                        const Eigen::Vector3d& pivot) {
    Eigen::Isometry3d move = Eigen::Isometry3d::Identity();
    move.linear() = base::rotation_from_vector(step.head<3>()).toRotationMatrix();
    move.translation() = pivot - move.linear() * pivot + step.tail<3>();
    return move * T_a_b;
}

Eigen::Vector3d middle(const std::vector<Partner>& partners) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double num = 0.0;
    for (const Partner& partner : partners)
        if (partner.found) {
            sum += partner.p;
            num += 1.0;
        }
    return num > 0.0 ? Eigen::Vector3d(sum / num) : sum;
}

std::vector<Eigen::Vector3f> shrunk(std::span<const Eigen::Vector3f> points,
                                    const Eigen::Vector3f& about,
                                    double share) {
    std::vector<Eigen::Vector3f> result(points.begin(), points.end());
    for (Eigen::Vector3f& p : result) p = about + static_cast<float>(1.0 - share) * (p - about);
    return result;
}

// Returns by how much b is larger than a, near the pose of ICP. Partners are found again with each
// scale: those of another scale are neighbours, which hides part of the difference.
std::optional<ScaleDifference> scale_difference(
    const SurfacePoints& a,
    const SurfacePoints& b,
    const CoRegistration& icp,
    const IcpOptions& options,
    double reach_m,
    std::vector<std::optional<std::uint32_t>>& nearest_points) {
    constexpr int kMaxRounds = 8;
    constexpr double kSettled_sigmas = 0.1;
    Eigen::Isometry3d T_a_b = icp.T_a_b;
    ScaleDifference total;
    for (int round = 0; round < kMaxRounds; ++round) {
        const Eigen::Vector3d pivot_b = T_a_b.inverse() * icp.pivot;
        const auto points = shrunk(b.points, pivot_b.cast<float>(), total.value);
        const auto partners = find_partners(
            a, {points, b.normals, b.sigma_m, b.grid}, T_a_b, options, reach_m, nearest_points);
        const auto step = solve_with_scale(
            linearise(partners, robust_scale(partners), icp.pivot, options.patch_m));
        if (!step || !step->pose.allFinite()) return std::nullopt;
        total = {total.value + step->scale.value, step->scale.sigma, step->scale.lever_m};
        if (std::abs(step->scale.value) < kSettled_sigmas * step->scale.sigma) break;
        T_a_b = moved(T_a_b, step->pose, icp.pivot);
    }
    return total;
}

}  // namespace

Vector6d motion_along(const Eigen::Vector3d& lever_m, const Eigen::Vector3d& direction) {
    Vector6d row;
    row << lever_m.cross(direction), direction;
    return row;
}

double CoRegistration::sigma_m(const Eigen::Vector3d& p, const Eigen::Vector3d& direction) const {
    const Vector6d row = motion_along(p - pivot, direction);
    return std::sqrt(std::max(0.0, row.dot(covariance * row)));
}

std::optional<CoRegistration> point_to_plane_icp(const SurfacePoints& a,
                                                 const SurfacePoints& b,
                                                 const Eigen::Isometry3d& T_a_b,
                                                 const IcpOptions& options) {
    using Termination = types::SolverOutcome::Termination;
    CoRegistration result;
    types::SolverOutcome& outcome = result.outcome;
    outcome.termination = Termination::StoppedAtLimit;
    outcome.message = "the last step was still large";
    result.T_a_b = T_a_b;
    double reach_m = options.max_step_m;
    std::vector<std::optional<std::uint32_t>> nearest_points(b.points.size());
    for (int round = 0; round < options.max_rounds; ++round) {
        const auto partners = find_partners(a, b, result.T_a_b, options, reach_m, nearest_points);
        const auto num_found = static_cast<std::size_t>(
            std::ranges::count_if(partners, [](const Partner& p) { return p.found; }));
        if (num_found < kMinPartners) return std::nullopt;
        const double scale_m = robust_scale(partners);
        result.pivot = middle(partners);
        const Fit fit = linearise(partners, scale_m, result.pivot, options.patch_m);
        const double min_reach_m = std::max(2.0 * options.tolerance_m, 5.0 * scale_m);
        // Both worlds are upright: a tilt that is free before the rest fits would absorb the
        // changes.
        const Vector6d step = reach_m > min_reach_m ? solve_upright(fit) : solve(fit);
        result.covariance = sandwich(fit);
        result.num_patches = fit.patches.size();
        result.residual_rms_m = std::sqrt(fit.squares / std::max(1e-12, fit.weights));
        result.stable_share = static_cast<double>(fit.num_used) / static_cast<double>(num_found);
        ++outcome.num_iterations;
        outcome.final_cost = result.residual_rms_m * result.residual_rms_m;
        if (round == 0) outcome.initial_cost = outcome.final_cost;
        outcome.last_step_sigmas = step_sigmas(step, fit, result.covariance, scale_m);
        if (!step.allFinite()) {
            outcome.termination = Termination::Failed;
            outcome.message = "the last step is not finite";
            break;
        }
        result.T_a_b = moved(result.T_a_b, step, result.pivot);
        if (step.tail<3>().norm() < kSettled_m && reach_m <= min_reach_m) {
            outcome.termination = Termination::Converged;
            outcome.message = "the last step was small";
            break;
        }
        reach_m = std::max(min_reach_m, 0.8 * reach_m);
    }
    result.scale = scale_difference(a, b, result, options, reach_m, nearest_points);
    return result;
}

}  // namespace divemesh::compare
