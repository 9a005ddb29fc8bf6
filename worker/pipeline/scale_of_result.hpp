#pragma once

#include "worker/evaluation/scale_sources.hpp"
#include "worker/pipeline/reconstruction.hpp"

namespace divemesh::pipeline {

// Returns the covariances of the trajectory without the error of the scale that all poses share:
// known lengths measure it, and it is no drift between the ends of one.
types::CovarianceTrack covariances_without_scale(const types::OptimisedTrack& optimised);

// Returns the scale of the current result by each source that measures lengths besides the cameras.
// Called before the scale is corrected, and again for the scale that is reported. Known distances
// that are not marked in the images count once they are evaluated.
evaluation::ScaleSources scale_sources(const Reconstruction& made);

// Scales the result: every pose, and what is known of the error of its scale. `sigma` is that of
// the factor. Poses must not have been used yet, so that all results have the same scale.
void scale_result(double factor, double sigma, Reconstruction& made);

}  // namespace divemesh::pipeline
