#include "worker/evaluation/scaled_uncertainty.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>

#include "worker/evaluation/tracking_segments.hpp"

namespace divemesh::evaluation {
namespace {

constexpr double kMaxShare = 0.99;  // of a variance that the scale's error may be

// Removes the scale's error, known by its direction and size.
void remove(const Eigen::Vector3d& error_m, Eigen::Matrix3d& covariance_m2) {
    const double sigmas2 = error_m.dot(covariance_m2.ldlt().solve(error_m));
    if (sigmas2 > 0.0)
        covariance_m2 -= std::min(1.0, kMaxShare / sigmas2) * error_m * error_m.transpose();
}

}  // namespace

std::vector<Eigen::Vector3d> offsets_from_start(const types::Trajectory& trajectory,
                                                const std::vector<types::Keyframe>& keyframes,
                                                const types::Breaks& breaks_ns) {
    std::vector<Eigen::Vector3d> ways(trajectory.size(), Eigen::Vector3d::Zero());
    if (trajectory.empty()) return ways;
    const Eigen::Matrix3d R_first_world = trajectory.front().T_world_imu.linear().transpose();
    const std::vector<std::size_t> numbers = segment_numbers(trajectory, keyframes, breaks_ns);
    std::map<std::size_t, Eigen::Vector3d> starts_world;
    for (std::size_t i = 0; i < trajectory.size(); ++i) {
        const Eigen::Vector3d p_world = trajectory[i].T_world_imu.translation();
        const auto start = starts_world.try_emplace(numbers[i], p_world).first;
        ways[i] = R_first_world * (p_world - start->second);
    }
    return ways;
}

types::CovarianceTrack with_scale_sigma(const types::CovarianceTrack& covariances,
                                        const std::vector<Eigen::Vector3d>& offsets_from_start,
                                        double from_sigma,
                                        double to_sigma) {
    types::CovarianceTrack result = covariances;
    for (std::size_t i = 0; i < std::min(result.size(), offsets_from_start.size()); ++i) {
        const Eigen::Vector3d& way = offsets_from_start[i];
        remove(from_sigma * way, result[i].position_m2);
        result[i].position_m2 += to_sigma * to_sigma * way * way.transpose();
    }
    return result;
}

types::PathUncertainty scaled(const types::PathUncertainty& path, double factor, double sigma) {
    types::PathUncertainty result = path;
    const double old_sigma = path.shared_scale_sigma;
    const double by_drift2 =
        std::max(0.0, path.scale_sigma * path.scale_sigma - old_sigma * old_sigma);
    result.scale_sigma = std::sqrt(by_drift2 + sigma * sigma);
    result.shared_scale_sigma = sigma;
    const double squared = factor * factor;
    result.spread_m2 *= squared;
    result.mean_square_m2 *= squared;
    if (!path.is_known()) return result;
    // With N P = W + s u u', s the shared variance along the scale's direction u: tr(N P N P) =
    // tr(W W) + 2 s u' W u + s^2, and tr(N P N P) / n^2 = E^2 / h.
    const double drift = by_drift2 * result.spread_m2;
    const double before = old_sigma * old_sigma * result.spread_m2;
    const double after = sigma * sigma * result.spread_m2;
    const double mean = result.mean_square_m2;
    const double squares = mean * mean / path.degrees_of_freedom - before * (before + 2.0 * drift);
    result.mean_square_m2 = std::max(0.0, mean - before) + after;
    result.degrees_of_freedom =
        std::max(1.0,
                 result.mean_square_m2 * result.mean_square_m2 /
                     (std::max(0.0, squares) + after * (after + 2.0 * drift)));
    return result;
}

}  // namespace divemesh::evaluation
