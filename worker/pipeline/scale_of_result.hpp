#pragma once

#include "worker/evaluation/scale_sources.hpp"
#include "worker/pipeline/reconstruction.hpp"

namespace divemesh::pipeline {

// Returns the covariances of the trajectory without the error of the scale that all poses share:
// known lengths measure it, and it is no drift between the ends of one.
types::CovarianceTrack covariances_without_scale(const types::OptimisedTrack& optimised);

// Returns the covariances of the trajectory as they are stated: they cover a contradiction of the
// scale.
types::CovarianceTrack stated_covariances(const types::OptimisedTrack& optimised);

// Returns the scale of the current result by each source that measures lengths besides the cameras.
// Called before the scale is corrected, and again for the scale that is reported. Known distances
// that are not marked in the images count once they are evaluated.
evaluation::ScaleSources scale_sources(const Reconstruction& made);

// Scales the result: every pose, and what is known of the error of its scale. `sigma` is that of
// the factor. Poses must not have been used yet, so that all results have the same scale.
void scale_result(double factor, double sigma, Reconstruction& made);

// Has all results cover what another measurement of lengths contradicts their scale by: covariances
// of the trajectory, bars, mesh. Called once, when the known distances are evaluated. Returns false
// if nothing contradicts it.
bool cover_contradiction(Reconstruction& made);

}  // namespace divemesh::pipeline
