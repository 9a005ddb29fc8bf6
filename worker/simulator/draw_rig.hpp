#pragma once

#include <cstdint>

#include "worker/types/rig.hpp"

namespace divemesh::simulator {

// Returns a stereo rig with an IMU, drawn by seed within the range of such rigs: 100 degrees of
// diagonal view or less, baseline 0.10 to 0.15 m, some barrel distortion, cameras half a degree
// apart, body axes forward, left, up. Every seed gives another rig; another lens changes nothing
// else of it.
types::Rig draw_rig(int width_px,
                    int height_px,
                    std::uint64_t seed,
                    types::Distortion lens = types::Distortion::RadialTangential);

}  // namespace divemesh::simulator
