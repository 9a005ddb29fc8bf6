#pragma once

#include <cstdint>

#include "worker/types/pose_covariance.hpp"

namespace divemesh::worker {

// Linearly between those of the keyframes, beyond their ends as at the end.
PoseCovariance covariance_between(const CovarianceTrack& keyframes, std::int64_t timestamp_ns);

}  // namespace divemesh::worker
