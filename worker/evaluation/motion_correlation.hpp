#pragma once

#include <vector>

#include "worker/types/recording.hpp"

namespace divemesh::evaluation {

// Returns whether a trajectory's orientations change at all, by two degrees or more.
bool has_rotation(const types::Trajectory& trajectory);

// Returns the time offsets (truth's clock minus the estimate's, s) at which the motions are most
// alike, best first: the maxima of the correlation (Pearson) of the rates of rotation, or of the
// speeds if one trajectory has no rotations, with at least half of the estimate inside the truth.
// Both are independent of the world frame, rates of rotation of the body frame too. Empty if they
// correlate nowhere.
std::vector<double> likely_time_offsets_s(const types::Trajectory& estimate,
                                          const types::Trajectory& truth);

}  // namespace divemesh::evaluation
