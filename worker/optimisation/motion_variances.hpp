#pragma once

#include <cstddef>
#include <vector>

#include "worker/types/motion_sigma.hpp"

namespace divemesh::optimisation {

// Variances per axis.
struct MotionVariance {
    double position_m2 = 0.0;
    double rotation_rad2 = 0.0;
};

// Returns the variances of the odometry's motion from the frame `from` to each frame until `to`,
// the sums of those of its steps: the first is 0, the last that of the whole motion. `sigmas` holds
// the step to each frame of the dive.
std::vector<MotionVariance> summed_variances(const std::vector<types::MotionSigma>& sigmas,
                                             std::size_t from,
                                             std::size_t to);

}  // namespace divemesh::optimisation
