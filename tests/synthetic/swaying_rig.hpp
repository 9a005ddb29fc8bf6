#pragma once

#include <Eigen/Geometry>
#include <cmath>

#include "worker/base/rotation_vector.hpp"

namespace divemesh::synthetic {

// Returns the pose of a rig that swims on and sways about all axes.
inline Eigen::Isometry3d T_world_swaying(double t_s) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() =
        (base::rotation_from_vector({0.2 * std::sin(0.9 * t_s) + 0.1 * std::sin(2.1 * t_s), 0, 0}) *
         base::rotation_from_vector({0, 0.2 * std::sin(0.7 * t_s), 0}) *
         base::rotation_from_vector({0, 0, 0.1 * t_s + 0.2 * std::sin(1.3 * t_s)}))
            .toRotationMatrix();
    pose.translation() << 0.2 * t_s, 0.1 * std::sin(0.5 * t_s), 0.0;
    return pose;
}

}  // namespace divemesh::synthetic
