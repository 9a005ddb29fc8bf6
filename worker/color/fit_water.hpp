#pragma once

#include "worker/base/parallel.hpp"
#include "worker/color/color_fit.hpp"
#include "worker/color/sighting.hpp"

namespace divemesh::color {

// Fits the revised image formation model (ChannelFit) to surface that several keyframes show from
// different ranges, with gains (auto exposure; of each keyframe, between 400 knots on longer dives)
// and vignetting. The fit chooses what lights the surface. What three channels cannot tell stays
// open: the colour of the light itself (white_point.hpp). An outcome other than Estimated says why
// the water is not known. Reports progress, and so can be cancelled, at each step of the solver.
ColorFit fit_water(const Sightings& sightings,
                   int num_threads,
                   const base::ProgressShare& progress = {});

}  // namespace divemesh::color
