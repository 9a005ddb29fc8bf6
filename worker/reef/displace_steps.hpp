#pragma once

#include <cstdint>

#include "worker/reef/height_grid.hpp"

namespace divemesh::reef {

// How far steps lie beside their true places.
struct StepDisplacement {
    double deviation_m = 0.0;  // one standard deviation along each of both axes
    double alike_m = 0.0;      // length over which it falls to 1/e
    std::uint64_t seed = 0;
};

// Returns the surface with its steps (parts steeper than 45 degrees) moved along the plane, each by
// its own random distance. Gentler ground stays unchanged, as do unseen nodes.
HeightGrid with_steps_displaced(const HeightGrid& grid, const StepDisplacement& displacement);

}  // namespace divemesh::reef
