#pragma once

#include <vector>

#include "worker/types/recording.hpp"

namespace divemesh::evaluation {

// Whether a trajectory's orientations change at all: by two degrees or more.
bool has_rotation(const types::Trajectory& trajectory);

// Offsets (truth's clock minus the estimate's, s) at which both move most alike, best first: where
// rates of rotation, or speeds where one has no rotations, correlate (Pearson), at least half of
// the estimate inside the truth. Neither depends on frames; rates of rotation not on the body
// either. Nothing where they correlate nowhere.
std::vector<double> likely_time_offsets_s(const types::Trajectory& estimate,
                                          const types::Trajectory& truth);

}  // namespace divemesh::evaluation
