#pragma once

#include <Eigen/Geometry>

namespace divemesh::types {

// A rotation measured by the IMU, with its uncertainty.
struct KnownRotation {
    Eigen::Quaterniond q;
    double sigma_rad = 0.0;
};

}  // namespace divemesh::types
