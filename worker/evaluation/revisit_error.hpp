#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "worker/evaluation/trajectory_pairs.hpp"

namespace divemesh::evaluation {

// The error of a path at revisited places: each frame is compared with the nearest (in truth) of
// those taken at least 10 s earlier within half a metre and 45 degrees of viewing direction. It is
// the error of the estimated motion between the two.
struct RevisitError {
    std::int64_t num_frames = 0;  // that revisit a place
    double translation_rmse_m = 0.0;
    double translation_max_m = 0.0;
    double rotation_rmse_deg = 0.0;
};

// Returns nullopt if the path revisits no place.
std::optional<RevisitError> revisit_error(const std::vector<PosePair>& pairs);

}  // namespace divemesh::evaluation
