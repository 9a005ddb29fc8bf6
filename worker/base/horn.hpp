#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

namespace divemesh::base {

// The similarity transform between two point sets.
struct AbsoluteOrientation {
    Eigen::Isometry3d T_b_a = Eigen::Isometry3d::Identity();  // rigid: without the scale
    double scale = 1.0;  // of b against a, Horn's symmetric estimate; not applied to T_b_a
};

// Returns the rotation, translation and scale that align points a with points b: B. Horn,
// "Closed-form solution of absolute orientation using unit quaternions", 1987. nullopt for fewer
// than three pairs, or if all points lie on one line.
std::optional<AbsoluteOrientation> absolute_orientation(const std::vector<Eigen::Vector3d>& a,
                                                        const std::vector<Eigen::Vector3d>& b);

}  // namespace divemesh::base
