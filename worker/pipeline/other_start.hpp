#pragma once

#include "worker/types/track.hpp"

namespace divemesh::pipeline {

// Moves keyframes and landmarks to where bundle adjustment can start instead: keyframes to their
// poses by odometry, which no window and no loop has moved, and landmarks to where the first
// keyframe with a disparity sees them. A landmark without disparity stays where it is.
void start_from_odometry(types::Track& track);

}  // namespace divemesh::pipeline
