#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "worker/types/keyframe.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::optimisation {

// Index of the frame with this stamp.
std::size_t frame_at(const types::Trajectory& frames, std::int64_t timestamp_ns);

// `frames`, some of those of `trajectory`, as posed there; each belongs to the piece of the last
// keyframe before it.
std::vector<types::Keyframe> posed_by(const types::Trajectory& trajectory,
                                      const std::vector<types::Keyframe>& keyframes,
                                      const Eigen::Isometry3d& T_imu_cam,
                                      std::vector<types::Keyframe> frames);

// The poses of all frames once those of the keyframes are known: between two keyframes a frame
// moves as `odometry` (T_start_imu) says, and what the odometry misses from one keyframe to the
// next is spread over the frames between by time. After the last keyframe of a piece frames go on
// by the odometry alone.
types::Trajectory follow_keyframes(const types::Trajectory& odometry,
                                   const std::vector<types::Keyframe>& keyframes,
                                   const Eigen::Isometry3d& T_imu_cam);

}  // namespace divemesh::optimisation
