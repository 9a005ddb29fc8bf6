#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

namespace divemesh::base {

struct AbsoluteOrientation {
    Eigen::Isometry3d T_b_a = Eigen::Isometry3d::Identity();  // with scale 1
    double scale = 1.0;  // of b against a, Horn's symmetric estimate; not applied to T_b_a
};

// The rotation, translation and scale that bring points a onto points b: B. Horn, "Closed-form
// solution of absolute orientation using unit quaternions", 1987. Nothing when fewer than three
// pairs, or all on one line.
std::optional<AbsoluteOrientation> absolute_orientation(const std::vector<Eigen::Vector3d>& a,
                                                        const std::vector<Eigen::Vector3d>& b);

}  // namespace divemesh::base
