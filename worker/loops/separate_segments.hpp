#pragma once

#include <vector>

#include "worker/loops/drift_model.hpp"
#include "worker/loops/loop.hpp"

namespace divemesh::loops {

// Numbers the tracking segments. A dive that loses the scene starts a new segment, unless the gap
// is bridged (by inertial sensors or because it is shorter than a second) or a loop connects it to
// an earlier one. Segments are numbered from 0 in the order of their first keyframes.
void number_segments(const DriftModel& drift,
                     const std::vector<Loop>& loops,
                     std::vector<types::Keyframe>& keyframes);

// Moves each segment along world x, away from those before it. The relative position of segments is
// a guess, and surfaces that may not belong together must not overlap. `reach_m` is how far the
// cameras see.
void separate_segments(double reach_m, std::vector<types::Keyframe>& keyframes);

}  // namespace divemesh::loops
