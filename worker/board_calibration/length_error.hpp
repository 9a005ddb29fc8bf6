#pragma once

#include <optional>
#include <vector>

#include "worker/board_calibration/rig_parameters.hpp"

namespace divemesh::board_calibration {

// The standard deviation of a length that the rig measures, over that length, as far as it comes
// from the calibration: of a bar a fifth as long as its distance, in the worst of three directions:
// across, upright and along the line of sight.
struct LengthError {
    double distance_m = 0.0;
    std::optional<double> center;  // in the middle of the left image; nullopt: not in both images
    std::optional<double> border;  // in the worst place a tenth from a border of both images
};

// Returns the errors at 1, 2 and 3 m.
std::vector<LengthError> length_errors(const RigParameters& rig, const RigCovariance& covariance);

}  // namespace divemesh::board_calibration
