#pragma once

#include <optional>
#include <vector>

#include "schemas/finding.hpp"
#include "worker/types/track.hpp"

// What the user is told about frames whose motion was not measured.
namespace divemesh::pipeline {

// The remedy where the cause of a loss is not known.
inline constexpr const char* kTrackBetter =
    "check that left and right images are sharp, simultaneous and fit the calibration; keep "
    "textured ground in view, swim slower or record more pairs a second";

// Returns an error if vision constrained hardly any motion, so that there is no model.
std::optional<Finding> too_little_tracked(const types::Track& track);

// Returns the findings about lost motions: one on the whole, then one with cause and remedy for
// each of the longest losses.
std::vector<Finding> tracking_findings(const types::Track& track);

}  // namespace divemesh::pipeline
