#pragma once

#include <Eigen/Geometry>

namespace divemesh::evaluation {

// How estimated and true poses are paired.
struct TrajectoryErrorOptions {
    // Pose of the estimate's body in the reference's body; the identity if both follow the same
    // body. Without it, aligning a camera's path with an IMU's is wrong as soon as the rig rotates.
    Eigen::Isometry3d T_referencebody_estimatebody = Eigen::Isometry3d::Identity();
    bool pair_by_index = false;         // KITTI: line by line, timestamps are ignored
    double max_gap_s = 1.0;             // no interpolation across larger gaps of the truth
    double max_extrapolation_s = 0.01;  // the truth is held constant for so long beyond its ends
};

}  // namespace divemesh::evaluation
