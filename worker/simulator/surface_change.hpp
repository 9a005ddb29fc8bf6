#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "worker/simulator/scene.hpp"

namespace divemesh::simulator {

// A connected region where the surface seen from above rose or sank. Space under an overhang counts
// as filled, as in the comparison of two surveys.
struct SurfaceChange {
    std::vector<std::string> names;  // changed objects in it, before or after
    bool grown = false;              // else lost
    double area_m2 = 0.0;            // seen from above
    double volume_m3 = 0.0;          // between the two surfaces
    Eigen::AlignedBox2d box_world;
};

inline constexpr double kSurfaceChangeCell_m = 0.005;

// Returns the changed regions: both scenes are sampled by vertical rays kSurfaceChangeCell_m apart,
// within the bounds of the changes that `after` lists. Cells that change by more than 1 mm are
// joined over sides and corners.
std::vector<SurfaceChange> surface_changes(const Scene& before, const Scene& after);

}  // namespace divemesh::simulator
