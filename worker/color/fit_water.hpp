#pragma once

#include "worker/color/color_fit.hpp"
#include "worker/color/sighting.hpp"

namespace divemesh::color {

// Fits the revised image formation model (ChannelFit) to surface that several keyframes show from
// different ranges, with a gain per keyframe (auto exposure) and vignetting. The fit chooses what
// lights the surface. What three channels cannot tell stays open: the colour of the light itself
// (white_point.hpp). An outcome other than Estimated says why the water is not known.
ColorFit fit_water(const Sightings& sightings, int num_threads);

}  // namespace divemesh::color
