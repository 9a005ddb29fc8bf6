#pragma once

#include <optional>
#include <vector>

#include "schemas/finding.hpp"
#include "worker/types/track.hpp"

// Findings about frames whose motion was not measured, and about reduced images.
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

// Return a finding about images that were reduced: because of their size, or because vision lost
// the scene in larger ones.
Finding large_images_finding(int reduction);
Finding soft_images_finding(int reduction);

}  // namespace divemesh::pipeline
