#pragma once

#include "worker/base/instructions.hpp"
#include "worker/stereo/padded_disparity.hpp"

namespace divemesh::stereo {

// A winner of the matcher that its checks did not confirm (a negative disparity) is believed where
// at least three pairs of confirmed disparities on opposite sides within 8 px say the same: it then
// gets their mean. In two rounds, the second from what the first gave. What no winner supports, or
// lies beside a surface and not within, stays a hole (0). `spare` is written to.
void fill_holes(PaddedDisparity& disparity_px,
                PaddedDisparity& spare,
                base::Instructions instructions = base::best_instructions());

}  // namespace divemesh::stereo
