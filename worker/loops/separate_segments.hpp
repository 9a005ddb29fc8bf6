#pragma once

#include <vector>

#include "worker/loops/drift_model.hpp"
#include "worker/loops/loop.hpp"

namespace divemesh::loops {

// A dive that loses the scene goes on in a new piece, unless the track follows on, by inertia or
// because it was for less than a second, or a loop ties what follows to what was seen before.
// Pieces are numbered in the order of their first keyframes, from 0 on.
void number_segments(const DriftModel& drift,
                     const std::vector<Loop>& loops,
                     std::vector<types::Keyframe>& keyframes);

// Where a piece lies against the others is a guess. So that surfaces are not laid over each other
// that may not belong together, each is moved along world x, out of the way of those before it;
// `reach_m` is how far its cameras see.
void separate_segments(double reach_m, std::vector<types::Keyframe>& keyframes);

}  // namespace divemesh::loops
