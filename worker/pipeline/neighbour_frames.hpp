#pragma once

#include <cstddef>
#include <vector>

#include "worker/types/keyframe.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::pipeline {

// Returns up to four frames around `frame` that show surface at its depth, `depth_m`, from other
// places: of its segment, looking the same way, and with a baseline between 2 and 40 % of the
// depth, as near to 10 % as there are, on both sides in time if possible.
std::vector<std::size_t> neighbour_frames(const std::vector<types::Keyframe>& frames,
                                          std::size_t frame,
                                          double depth_m);

// Returns frames that show the scene from places at least 4 % of its depth apart, or turned by 5
// degrees, in order: enough for each surface to be seen in several of them.
std::vector<std::size_t> frames_apart(const std::vector<types::Keyframe>& frames, double depth_m);

}  // namespace divemesh::pipeline
