#pragma once

#include <cstddef>
#include <vector>

#include "worker/loops/drift_model.hpp"
#include "worker/loops/stored_keypoints.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::loops {

// Two keyframes that may show the same place.
struct LoopCandidate {
    std::size_t from = 0;  // the earlier keyframe
    std::size_t to = 0;
};

// Returns for every `wanted` keyframe the few most similar earlier ones that the track does not
// connect to it already and that may show the same place, given the drift. Empty without keypoints.
std::vector<LoopCandidate> find_candidates(const types::RectifiedRig& rig,
                                           const std::vector<types::Keyframe>& keyframes,
                                           const StoredKeypoints& keypoints,
                                           const DriftModel& drift,
                                           const std::vector<bool>& wanted);

}  // namespace divemesh::loops
