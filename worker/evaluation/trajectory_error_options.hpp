#pragma once

#include <Eigen/Geometry>

namespace divemesh::evaluation {

struct TrajectoryErrorOptions {
    // Where the estimate's body sits in the reference's body; the identity when both follow the
    // same one. Aligning a camera's path to an IMU's without this is wrong as soon as it turns.
    Eigen::Isometry3d T_referencebody_estimatebody = Eigen::Isometry3d::Identity();
    bool pair_by_index = false;         // KITTI: line by line, stamps play no part
    double max_gap_s = 1.0;             // truth further apart than this is not interpolated
    double max_extrapolation_s = 0.01;  // beyond its ends the truth holds still for so long
};

}  // namespace divemesh::evaluation
