#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "worker/evaluation/trajectory_pairs.hpp"

namespace divemesh::evaluation {

// How well a path knows that it is back: frames against the nearest, in truth, of those that were
// taken at least 10 s before them, within half a metre and 45 degrees of view. What the estimate
// adds to the true motion between the two.
struct RevisitError {
    std::int64_t num_frames = 0;  // that were at an earlier place again
    double translation_rmse_m = 0.0;
    double translation_max_m = 0.0;
    double rotation_rmse_deg = 0.0;
};

// Nothing when the path never comes back.
std::optional<RevisitError> revisit_error(const std::vector<PosePair>& pairs);

}  // namespace divemesh::evaluation
