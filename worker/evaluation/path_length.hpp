#pragma once

#include "worker/types/recording.hpp"

namespace divemesh::worker {

// Of the straight lines from pose to pose, m.
double path_length_m(const Trajectory& trajectory);

}  // namespace divemesh::worker
