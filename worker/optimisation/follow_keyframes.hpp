#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "worker/types/breaks.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/motion_sigma.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::optimisation {

// Returns the index of the frame with this timestamp.
std::size_t frame_at(const types::Trajectory& frames, std::int64_t timestamp_ns);

// The frames of an interval that measured motions tie to the keyframe at its start (those before
// `end_of_first`) and to the one at its end (those from `begin_of_second` on). Without a break both
// ends tie all of them.
struct Ties {
    std::size_t end_of_first = 0;
    std::size_t begin_of_second = 0;
    bool broken = false;
};

// Returns the ties of the frames from `from` to `to`, the frames of two keyframes.
Ties ties_between(const types::Trajectory& odometry,
                  const types::Breaks& breaks_ns,
                  std::size_t from,
                  std::size_t to);

// Returns `frames`, a subset of `trajectory`, with its poses. Each belongs to the segment of the
// last keyframe before it.
std::vector<types::Keyframe> posed_by(const types::Trajectory& trajectory,
                                      const std::vector<types::Keyframe>& keyframes,
                                      const Eigen::Isometry3d& T_imu_cam,
                                      std::vector<types::Keyframe> frames);

// Returns the poses of all frames, given those of the keyframes. Between two keyframes a frame
// moves as in `odometry` (T_start_imu), and the odometry's error from one keyframe to the next is
// distributed over its steps by their variances: `sigmas`, of the step to each frame. Where a
// motion between the two was not measured (`breaks_ns`), the frames before it follow the first
// keyframe alone, and those after it the second. After the last keyframe of a segment frames follow
// the odometry alone.
types::Trajectory follow_keyframes(const types::Trajectory& odometry,
                                   const std::vector<types::MotionSigma>& sigmas,
                                   const std::vector<types::Keyframe>& keyframes,
                                   const Eigen::Isometry3d& T_imu_cam,
                                   const types::Breaks& breaks_ns = {});

}  // namespace divemesh::optimisation
