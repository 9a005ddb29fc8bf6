#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "worker/types/keyframe.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::worker {

// Index of the frame with this stamp.
std::size_t frame_at(const Trajectory& frames, std::int64_t timestamp_ns);

// `frames`, some of those of `trajectory`, as posed there; each belongs to the piece of the last
// keyframe before it.
std::vector<Keyframe> posed_by(const Trajectory& trajectory,
                               const std::vector<Keyframe>& keyframes,
                               const Eigen::Isometry3d& T_imu_cam,
                               std::vector<Keyframe> frames);

// The poses of all frames once those of the keyframes are known: between two keyframes a frame
// moves as `odometry` (T_start_imu) says, and what the odometry misses from one keyframe to the
// next is spread over the frames between by time. After the last keyframe of a piece frames go on
// by the odometry alone.
Trajectory follow_keyframes(const Trajectory& odometry,
                            const std::vector<Keyframe>& keyframes,
                            const Eigen::Isometry3d& T_imu_cam);

}  // namespace divemesh::worker
