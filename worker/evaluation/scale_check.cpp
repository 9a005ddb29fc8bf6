#include "worker/evaluation/scale_check.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "worker/evaluation/trajectory_pairs.hpp"
#include "worker/stats/distributions.hpp"

namespace divemesh::evaluation {
namespace {

constexpr std::int64_t kPressureBin_ns = 500'000'000;
constexpr std::size_t kMinBins = 20;
constexpr double kMaxCorrelation = 0.95;
constexpr double kContradicts_sigmas = 3.0;
constexpr double kTapeSigma_m = 0.002;

// Means of a bin: depth, and the path's -z, x and y.
struct DepthBin {
    double depth_m = 0.0;
    Eigen::Vector4d path = Eigen::Vector4d::Zero();  // -z, x, y, 1
    double num = 0.0;
};

std::vector<DepthBin> depth_bins(const std::vector<types::PressureSample>& pressure,
                                 const types::Trajectory& trajectory) {
    std::vector<DepthBin> bins;
    std::int64_t bin_ends_ns = 0;
    for (const types::PressureSample& sample : pressure) {
        const auto pose = pose_at(trajectory, sample.timestamp_ns);
        if (!pose) continue;
        if (bins.empty() || sample.timestamp_ns >= bin_ends_ns) {
            bins.emplace_back();
            bin_ends_ns = sample.timestamp_ns + kPressureBin_ns;
        }
        const Eigen::Vector3d p = pose->translation();
        bins.back().depth_m += sample.depth_m;
        bins.back().path += Eigen::Vector4d(-p.z(), p.x(), p.y(), 1.0);
        bins.back().num += 1.0;
    }
    for (DepthBin& bin : bins) {
        bin.depth_m /= bin.num;
        bin.path /= bin.num;
    }
    return bins;
}

// Returns the number of correlated residuals that count as one independent residual (Bartlett
// 1946).
double repetition(const Eigen::VectorXd& residuals) {
    const Eigen::Index num = residuals.size();
    const double products = residuals.head(num - 1).dot(residuals.tail(num - 1));
    const double correlation = std::clamp(
        products / residuals.squaredNorm() + 1.0 / static_cast<double>(num), 0.0, kMaxCorrelation);
    return (1.0 + correlation) / (1.0 - correlation);
}

// Returns a standard deviation that was estimated from few independent residuals, widened so that
// three of it hold as much as three of a known one (Student's t).
double wide_sigma(double sigma, double degrees_of_freedom) {
    constexpr double kShare = 0.99865;  // of a normal variable below three sigmas
    return sigma * stats::student_t_quantile(kShare, std::max(1.0, degrees_of_freedom)) /
           kContradicts_sigmas;
}

double sigma_between_m(double length_m, const PathError& path) {
    if (path.extent_m <= 0.0) return 0.0;
    return path.far_sigma_m * std::sqrt(std::min(1.0, length_m / path.extent_m));
}

}  // namespace

std::optional<ScaleCheck> scale_by_pressure(const std::vector<types::PressureSample>& pressure,
                                            const types::Trajectory& trajectory,
                                            double sigma_by_poses) {
    const std::vector<DepthBin> bins = depth_bins(pressure, trajectory);
    if (bins.size() < kMinBins) return std::nullopt;
    Eigen::MatrixXd path(std::ssize(bins), 4);
    Eigen::VectorXd depth_m(std::ssize(bins));
    for (Eigen::Index i = 0; i < path.rows(); ++i) {
        path.row(i) = bins[static_cast<std::size_t>(i)].path.transpose();
        depth_m[i] = bins[static_cast<std::size_t>(i)].depth_m;
    }
    const Eigen::Matrix4d information =
        path.transpose() * path + 1e-9 * Eigen::Matrix4d::Identity();
    const Eigen::LDLT<Eigen::Matrix4d> factor(information);
    const Eigen::Vector4d solution = factor.solve(path.transpose() * depth_m);
    const Eigen::VectorXd residuals = depth_m - path * solution;
    const double times = repetition(residuals);
    // A smooth column takes as many degrees of freedom from correlated residuals as `times` columns
    // from white ones.
    const double degrees_of_freedom = std::max(1.0, static_cast<double>(path.rows()) - 4.0 * times);
    const double inverse = factor.solve(Eigen::Vector4d::Unit(0)).x();  // 1 / squares of -z only
    const double variance = residuals.squaredNorm() / degrees_of_freedom * times * inverse;
    const double sigma =
        std::hypot(wide_sigma(std::sqrt(variance), degrees_of_freedom / times), sigma_by_poses);
    if (sigma <= 0.0) return std::nullopt;
    return ScaleCheck{solution[0], sigma};
}

std::optional<ScaleCheck> scale_by_distances(const KnownDistanceErrors& distances,
                                             const PathError& path) {
    if (distances.num_measured < 3) return std::nullopt;
    const double measured_over_known = 1.0 + distances.scale_error;
    double squares = 0.0;
    double known_squares = 0.0;
    double by_poses_m2 = 0.0;
    for (const MeasuredDistance& distance : distances.distances) {
        if (!distance.measured_m) continue;
        const double rest = *distance.measured_m - measured_over_known * distance.known_m;
        squares += rest * rest;
        known_squares += distance.known_m * distance.known_m;
        by_poses_m2 += distance.known_m * sigma_between_m(distance.known_m, path);
    }
    const double sigma = std::hypot(
        std::sqrt(squares / static_cast<double>(distances.num_measured - 1) / known_squares),
        by_poses_m2 / known_squares);
    if (sigma <= 0.0) return std::nullopt;
    return ScaleCheck{1.0 / measured_over_known, sigma};
}

ScaleCheck weighted_mean(const std::vector<ScaleCheck>& checks) {
    const auto information = [](const ScaleCheck& check) {
        return 1.0 / (check.sigma * check.sigma);
    };
    double weight = 0.0;
    double weighted = 0.0;
    for (const ScaleCheck& check : checks) {
        weight += information(check);
        weighted += information(check) * check.scale;
    }
    const double mean = weighted / weight;
    double chi2 = 0.0;
    for (const ScaleCheck& check : checks)
        chi2 += information(check) * std::pow(check.scale - mean, 2);
    const double ratio =
        checks.size() > 1 ? std::sqrt(chi2 / static_cast<double>(checks.size() - 1)) : 1.0;
    return {mean, std::max(1.0, ratio) / std::sqrt(weight)};
}

std::optional<ScaleCheck> scale_by_marked_distances(const KnownDistanceErrors& distances) {
    std::vector<ScaleCheck> checks;
    for (const MeasuredDistance& distance : distances.distances) {
        if (!distance.measured_m || !distance.sigma_m || *distance.measured_m <= 0.0) continue;
        const double sigma_m = std::hypot(*distance.sigma_m, kTapeSigma_m);
        checks.push_back({distance.known_m / *distance.measured_m, sigma_m / *distance.measured_m});
    }
    if (checks.empty()) return std::nullopt;
    return weighted_mean(checks);
}

bool is_contradicted(const ScaleCheck& check) {
    return std::abs(check.scale - 1.0) > kContradicts_sigmas * check.sigma;
}

nlohmann::json to_metrics(const ScaleCheck& check) {
    return {{"scale", check.scale}, {"sigma", check.sigma}};
}

}  // namespace divemesh::evaluation
