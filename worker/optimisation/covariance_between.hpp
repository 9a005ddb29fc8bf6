#pragma once

#include <cstdint>

#include "worker/types/pose_covariance.hpp"

namespace divemesh::optimisation {

// Linearly between those of the keyframes, beyond their ends as at the end.
types::PoseCovariance covariance_between(const types::CovarianceTrack& keyframes,
                                         std::int64_t timestamp_ns);

}  // namespace divemesh::optimisation
