#pragma once

#include "worker/types/recording.hpp"

namespace divemesh::evaluation {

// Returns the sum of the straight distances from pose to pose, m.
double path_length_m(const types::Trajectory& trajectory);

}  // namespace divemesh::evaluation
