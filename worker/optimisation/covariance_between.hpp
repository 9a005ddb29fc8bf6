#pragma once

#include <cstdint>

#include "worker/types/pose_covariance.hpp"

namespace divemesh::optimisation {

// Returns the covariance interpolated linearly between keyframes; before the first and after the
// last it is constant.
types::PoseCovariance covariance_between(const types::CovarianceTrack& keyframes,
                                         std::int64_t timestamp_ns);

}  // namespace divemesh::optimisation
