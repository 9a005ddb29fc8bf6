#include "worker/pipeline/known_motions.hpp"

#include <algorithm>
#include <cstdint>
#include <numbers>
#include <optional>

#include "worker/optimisation/follow_keyframes.hpp"

namespace divemesh::pipeline {
namespace {

// A rest may begin with the frame after a keyframe, and ends with the frame before the one in which
// motion shows. Images follow the rig over so short a time.
constexpr std::int64_t kMaxBesideRest_ns = 1'000'000'000;

// Returns the rest that fills the time from a keyframe to the next one.
std::optional<types::Rest> rest_between(const std::vector<types::Rest>& rests,
                                        const types::Keyframe& from,
                                        const types::Keyframe& to) {
    const auto rest = std::ranges::find_if(rests, [&](const types::Rest& r) {
        const std::int64_t common_ns =
            std::min(r.to_ns, to.timestamp_ns) - std::max(r.from_ns, from.timestamp_ns);
        return 2 * common_ns >= to.timestamp_ns - from.timestamp_ns &&
               r.from_ns <= from.timestamp_ns + kMaxBesideRest_ns &&
               r.to_ns >= to.timestamp_ns - kMaxBesideRest_ns;
    });
    if (rest == rests.end()) return std::nullopt;
    return *rest;
}

const Eigen::Isometry3d& pose_at(const types::Trajectory& trajectory, std::int64_t timestamp_ns) {
    return trajectory[optimisation::frame_at(trajectory, timestamp_ns)].T_world_imu;
}

}  // namespace

std::vector<optimisation::KnownMotion> known_motions(const types::Track& track,
                                                     const types::Track& closed,
                                                     const imu::InertialPrior& inertial,
                                                     const loops::DriftModel& drift) {
    std::vector<optimisation::KnownMotion> motions;
    for (std::size_t k = 1; k < closed.keyframes.size(); ++k) {
        const types::Keyframe& from = closed.keyframes[k - 1];
        const types::Keyframe& to = closed.keyframes[k];
        if (const auto rest = rest_between(track.rests, from, to)) {
            // The short motions before and after the rest have the same error once more.
            motions.push_back({k,
                               pose_at(track.odometry, from.timestamp_ns).inverse() *
                                   pose_at(track.odometry, to.timestamp_ns),
                               std::numbers::sqrt2 * rest->sigma_m,
                               std::numbers::sqrt2 * rest->sigma_rad});
        } else if (const auto& by_frames = drift.by_frames_alone(k)) {
            motions.push_back({k,
                               pose_at(closed.odometry, from.timestamp_ns).inverse() *
                                   pose_at(closed.odometry, to.timestamp_ns),
                               by_frames->position_m,
                               by_frames->rotation_rad});
        } else if (drift.segment(k) != drift.segment(k - 1) &&
                   !inertial.motion(from.timestamp_ns, to.timestamp_ns)) {
            const Eigen::Isometry3d& T_imu_cam = closed.rig.T_imu_cam;
            motions.push_back(
                {k,
                 T_imu_cam * from.T_world_cam.inverse() * to.T_world_cam * T_imu_cam.inverse(),
                 drift.position_sigma_m(k - 1, k),
                 drift.orientation_sigma_rad(k - 1, k)});
        }
    }
    return motions;
}

}  // namespace divemesh::pipeline
