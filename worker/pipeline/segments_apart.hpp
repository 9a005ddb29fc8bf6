#pragma once

#include <vector>

#include "worker/types/keyframe.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::pipeline {

// Moves the segments of a dive apart along world x. Returns the depth up to which frames may be
// fused so that the surfaces of two segments cannot meet; 0 (no limit) for a single segment. Voxels
// that fusion chooses itself make no surface beyond that depth.
double set_segments_apart(const types::RectifiedRig& rig,
                          double median_depth_m,
                          std::vector<types::Keyframe>& keyframes);

}  // namespace divemesh::pipeline
