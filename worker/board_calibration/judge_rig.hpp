#pragma once

#include <optional>
#include <string>
#include <vector>

#include "schemas/finding.hpp"
#include "worker/board_calibration/board_shape.hpp"
#include "worker/board_calibration/calibrate_rig.hpp"
#include "worker/board_calibration/length_error.hpp"
#include "worker/board_calibration/view_coverage.hpp"

namespace divemesh::board_calibration {

// What a calibration is good for, and what to do about it.
struct RigVerdict {
    bool usable = false;
    std::string text;  // "good to 0.08 % at 2 m"
    std::vector<LengthError> length_errors;
    ViewCoverage coverage;
    std::optional<BoardShape> shape;
    std::vector<Finding> findings;
};

// Judges by the errors of lengths that the covariance gives: usable up to 1 % at 2 m, with 95 %
// probability. Findings name views that harm and places where the board is to be held.
RigVerdict judge_rig(const boards::Board& board, const RigEstimate& estimate);

}  // namespace divemesh::board_calibration
