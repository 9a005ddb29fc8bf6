#pragma once

#include <Eigen/Geometry>

namespace divemesh::types {

// How far an orientation that the inertial unit gives is to be trusted.
struct KnownRotation {
    Eigen::Quaterniond q;
    double sigma_rad = 0.0;
};

}  // namespace divemesh::types
