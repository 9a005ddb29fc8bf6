#pragma once

#include "worker/types/recording.hpp"

namespace divemesh::evaluation {

// Of the straight lines from pose to pose, m.
double path_length_m(const types::Trajectory& trajectory);

}  // namespace divemesh::evaluation
