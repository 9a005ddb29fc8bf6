#pragma once

#include "worker/base/instructions.hpp"
#include "worker/stereo/padded_disparity.hpp"

namespace divemesh::stereo {

// Fills holes: an unconfirmed winner of the matcher (a negative disparity) is accepted if at least
// three pairs of confirmed disparities on opposite sides within 8 px agree with it. It then gets
// their mean. There are two rounds; the second uses the results of the first. A pixel without such
// a winner, or beside a surface instead of within it, stays a hole (0). `spare` is overwritten.
void fill_holes(PaddedDisparity& disparity_px,
                PaddedDisparity& spare,
                base::Instructions instructions = base::best_instructions());

}  // namespace divemesh::stereo
