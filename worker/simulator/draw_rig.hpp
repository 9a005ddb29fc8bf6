#pragma once

#include <cstdint>

#include "worker/types/rig.hpp"

namespace divemesh::simulator {

// A stereo rig with an IMU, drawn by seed within what such rigs have: 100 degrees of diagonal view
// or less, baseline 0.10 to 0.15 m, some barrel distortion, cameras half a degree apart, body axes
// forward, left, up. Never two alike.
types::Rig draw_rig(int width_px, int height_px, std::uint64_t seed);

}  // namespace divemesh::simulator
