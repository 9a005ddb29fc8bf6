#include "worker/evaluation/scaled_uncertainty.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>

#include "worker/stats/distributions.hpp"

namespace divemesh::evaluation {
namespace {

constexpr double kMaxShare = 0.99;  // of a variance that the scale's error may be

// Removes the scale's error, known by its direction and size.
void remove(const Eigen::Vector3d& error_m, Eigen::Matrix3d& covariance_m2) {
    const double sigmas2 = error_m.dot(covariance_m2.ldlt().solve(error_m));
    if (sigmas2 > 0.0)
        covariance_m2 -= std::min(1.0, kMaxShare / sigmas2) * error_m * error_m.transpose();
}

// Returns which segment a pose belongs to; their number if it belongs to none.
std::ptrdiff_t segment_at(const std::vector<types::TrackingSegment>& segments,
                          std::int64_t timestamp_ns) {
    return std::ranges::find_if(
               segments,
               [&](const types::TrackingSegment& of) { return of.contains(timestamp_ns); }) -
           segments.begin();
}

// Where the poses of one segment are.
struct SegmentPlace {
    Eigen::AlignedBox1d along_x_m;
    Eigen::Vector3d sum_world_m = Eigen::Vector3d::Zero();
    double num_poses = 0.0;

    Eigen::Vector3f centre_world() const { return (sum_world_m / num_poses).cast<float>(); }
};

std::vector<SegmentPlace> places_of(const types::Trajectory& trajectory,
                                    const std::vector<types::TrackingSegment>& segments) {
    std::map<std::ptrdiff_t, SegmentPlace> places;
    for (const types::StampedPose& pose : trajectory) {
        const Eigen::Vector3d p_world = pose.T_world_imu.translation();
        SegmentPlace& place = places[segment_at(segments, pose.timestamp_ns)];
        place.along_x_m.extend(p_world.head<1>());
        place.sum_world_m += p_world;
        ++place.num_poses;
    }
    std::vector<SegmentPlace> result;
    for (const auto& [segment, place] : places) result.push_back(place);
    return result;
}

const SegmentPlace& nearest_along_x(const std::vector<SegmentPlace>& places, float x_m) {
    const Eigen::Matrix<double, 1, 1> x(static_cast<double>(x_m));
    return *std::ranges::min_element(places, {}, [&](const SegmentPlace& place) {
        return place.along_x_m.squaredExteriorDistance(x);
    });
}

}  // namespace

std::vector<Eigen::Vector3d> offsets_from_start(
    const types::Trajectory& trajectory, const std::vector<types::TrackingSegment>& segments) {
    std::vector<Eigen::Vector3d> ways(trajectory.size(), Eigen::Vector3d::Zero());
    if (trajectory.empty()) return ways;
    const Eigen::Matrix3d R_first_world = trajectory.front().T_world_imu.linear().transpose();
    std::map<std::ptrdiff_t, Eigen::Vector3d> starts_world;
    for (std::size_t i = 0; i < trajectory.size(); ++i) {
        const Eigen::Vector3d p_world = trajectory[i].T_world_imu.translation();
        const std::ptrdiff_t segment = segment_at(segments, trajectory[i].timestamp_ns);
        const auto start = starts_world.try_emplace(segment, p_world).first;
        ways[i] = R_first_world * (p_world - start->second);
    }
    return ways;
}

types::CovarianceTrack with_scale_sigma(const types::CovarianceTrack& covariances,
                                        const std::vector<Eigen::Vector3d>& offsets_from_start,
                                        double from_sigma,
                                        double to_sigma) {
    types::CovarianceTrack result = covariances;
    if (from_sigma == to_sigma) return result;
    for (std::size_t i = 0; i < std::min(result.size(), offsets_from_start.size()); ++i) {
        const Eigen::Vector3d& way = offsets_from_start[i];
        remove(from_sigma * way, result[i].position_m2);
        result[i].position_m2 += to_sigma * to_sigma * way * way.transpose();
    }
    return result;
}

types::Mesh with_scale_sigma(types::Mesh mesh,
                             const types::Trajectory& trajectory,
                             const std::vector<types::TrackingSegment>& segments,
                             double from_sigma,
                             double to_sigma) {
    if (mesh.normals.empty() || trajectory.empty() || from_sigma == to_sigma) return mesh;
    const std::vector<SegmentPlace> places = places_of(trajectory, segments);
    const auto added = static_cast<float>(to_sigma * to_sigma - from_sigma * from_sigma);
    for (std::size_t i = 0; i < mesh.sigma_m.size(); ++i) {
        const Eigen::Vector3f& vertex = mesh.vertices[i];
        const float along_m = mesh.normals[i].normalized().dot(
            vertex - nearest_along_x(places, vertex.x()).centre_world());
        const float variance_m2 = mesh.sigma_m[i] * mesh.sigma_m[i] + added * along_m * along_m;
        const float noise_m = mesh.sigma_local_m.empty() ? 0.0F : mesh.sigma_local_m[i];
        mesh.sigma_m[i] = std::max(noise_m, std::sqrt(std::max(0.0F, variance_m2)));
    }
    return mesh;
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

double contradiction_sigma(double scale_contradiction) {
    return scale_contradiction / stats::kNormal975;
}

double lengths_sigma(const types::PathUncertainty& path) {
    return std::hypot(path.scale_sigma_or_typical(), contradiction_sigma(path.scale_contradiction));
}

types::PathUncertainty covering_contradiction(const types::PathUncertainty& path) {
    if (path.scale_contradiction == 0.0) return path;
    const double sigma =
        std::hypot(path.shared_scale_sigma, contradiction_sigma(path.scale_contradiction));
    types::PathUncertainty result = scaled(path, 1.0, sigma);
    result.scale_contradiction = 0.0;
    return result;
}

}  // namespace divemesh::evaluation
