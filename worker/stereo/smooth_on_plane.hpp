#pragma once

#include "worker/base/instructions.hpp"
#include "worker/stereo/padded_disparity.hpp"

namespace divemesh::stereo {

// Averages each disparity with those pairs of opposite neighbours within 2 px whose own mean is
// within `gate_px` of the centre: planes of any slant stay as they are, edges stay sharp.
void smooth_on_plane(const PaddedDisparity& disparity_px,
                     float gate_px,
                     PaddedDisparity& smooth_px,
                     base::Instructions instructions = base::best_instructions());

// The same for uncertain disparities, with a gate of two standard deviations and neighbours three
// times as far. The standard deviation falls only with the fourth root of the number of windows
// that do not overlap: where texture is weak, the errors of neighbours are correlated. That of a
// wide window stays. Certain disparities stay as they are.
void smooth_uncertain(const PaddedDisparity& disparity_px,
                      const PaddedDisparity& sigma_px,
                      PaddedDisparity& smooth_px,
                      PaddedDisparity& smooth_sigma_px,
                      base::Instructions instructions = base::best_instructions());

}  // namespace divemesh::stereo
