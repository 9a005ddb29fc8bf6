#pragma once

#include <optional>
#include <vector>

#include "worker/types/motion_sigma.hpp"
#include "worker/types/track.hpp"

namespace divemesh::loops {

// How well the frames up to each keyframe know the odometry's motion from the keyframe before.
// nullopt: vision did not measure every step, or there is no keyframe before.
using MotionsInSight = std::vector<std::optional<types::MotionSigma>>;

// Returns the sigmas of the steps and the rests between keyframes, added up.
MotionsInSight motions_in_sight(const types::Track& track);

}  // namespace divemesh::loops
