#pragma once

#include "worker/base/instructions.hpp"
#include "worker/types/keyframe.hpp"

namespace divemesh::stereo {

// Completes a depth map by that of the same images at half their size, where a pixel is the mean of
// four and a window sees four times the area: it measures surface with weak texture, in haze or
// noise, that the full size does not. At silhouettes it is too wide, so it is not used there.
//
// - What the full size did not measure gets the half size's disparity with a larger sigma.
// - What the full size measured by its wide window or from the surface around is averaged with it,
//   weighted by the variances; disagreement raises sigma.
// - What the full size measured well stays; sigma rises where the half size contradicts.
//
// `half` is in px of the half size, as SingleScaleMatcher gives it.
void combine_scales(const types::DepthMap& half,
                    types::DepthMap& full,
                    base::Instructions instructions = base::best_instructions());

}  // namespace divemesh::stereo
