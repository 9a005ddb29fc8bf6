#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "worker/simulator/scene.hpp"

namespace divemesh::simulator {

// Where the surface seen from above rose or sank, as one connected piece. Space under an overhang
// counts as filled, as it does where two surveys are compared.
struct SurfaceChange {
    std::vector<std::string> names;  // the changed objects that stand or stood in it
    bool grown = false;              // else lost
    double area_m2 = 0.0;            // seen from above
    double volume_m3 = 0.0;          // between the two surfaces
    Eigen::AlignedBox2d box_world;
};

inline constexpr double kSurfaceChangeCell_m = 0.005;

// Both scenes under vertical rays kSurfaceChangeCell_m apart, within the bounds of what `after`
// says has changed; pieces with a change of more than 1 mm, joined by sides and corners.
std::vector<SurfaceChange> surface_changes(const Scene& before, const Scene& after);

}  // namespace divemesh::simulator
