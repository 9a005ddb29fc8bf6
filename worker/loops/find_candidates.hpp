#pragma once

#include <cstddef>
#include <vector>

#include "worker/loops/drift_model.hpp"
#include "worker/loops/stored_keypoints.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::loops {

struct LoopCandidate {
    std::size_t from = 0;  // the earlier keyframe
    std::size_t to = 0;
};

// For every keyframe that is `wanted` the few earlier ones that look most like it, among those that
// the track does not tie to it anyway and that, as far as the track may have drifted, may show the
// same place. None without views.
std::vector<LoopCandidate> find_candidates(const types::RectifiedRig& rig,
                                           const std::vector<types::Keyframe>& keyframes,
                                           const StoredKeypoints& views,
                                           const DriftModel& drift,
                                           const std::vector<bool>& wanted);

}  // namespace divemesh::loops
