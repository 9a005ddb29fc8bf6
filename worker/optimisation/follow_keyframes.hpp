#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "worker/types/keyframe.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::optimisation {

// Returns the index of the frame with this timestamp.
std::size_t frame_at(const types::Trajectory& frames, std::int64_t timestamp_ns);

// Returns `frames`, a subset of `trajectory`, with its poses. Each belongs to the segment of the
// last keyframe before it.
std::vector<types::Keyframe> posed_by(const types::Trajectory& trajectory,
                                      const std::vector<types::Keyframe>& keyframes,
                                      const Eigen::Isometry3d& T_imu_cam,
                                      std::vector<types::Keyframe> frames);

// Returns the poses of all frames, given those of the keyframes. Between two keyframes a frame
// moves as in `odometry` (T_start_imu), and the odometry's error from one keyframe to the next is
// distributed over the frames by time. After the last keyframe of a segment frames follow the
// odometry alone.
types::Trajectory follow_keyframes(const types::Trajectory& odometry,
                                   const std::vector<types::Keyframe>& keyframes,
                                   const Eigen::Isometry3d& T_imu_cam);

}  // namespace divemesh::optimisation
