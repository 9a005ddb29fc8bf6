#pragma once

#include <optional>

#include "worker/evaluation/scale_check.hpp"
#include "worker/pipeline/reconstruction.hpp"

namespace divemesh::pipeline {

// Returns the scale of the path by positions from outside, against the cameras'; nullopt without
// positions. Called before the scale is corrected.
std::optional<evaluation::ScaleCheck> scale_by_positions(const Reconstruction& made);

// Joins the path with what other instruments measured: moves all poses, replaces their covariances,
// puts segments whose place is known well enough into the world of the first, and sets
// `made.georeference`. Called once, after the scale is final and before poses are used. A source
// that contradicts the path is left out, with a finding; so are all if together they bend the path
// by more than its images allow.
void join_positions(Reconstruction& made);

}  // namespace divemesh::pipeline
