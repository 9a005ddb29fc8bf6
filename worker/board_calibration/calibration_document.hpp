#pragma once

#include <nlohmann/json.hpp>

#include "worker/board_calibration/judge_rig.hpp"

namespace divemesh::board_calibration {

// Returns calibration.json: values with their standard deviations, errors by camera and pair,
// coverage, verdict and findings.
nlohmann::json calibration_document(const RigEstimate& estimate, const RigVerdict& verdict);

}  // namespace divemesh::board_calibration
