#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/dive/finding_log.hpp"

namespace divemesh::dive {

// The turning of the rig over a short time, as mean rates in rad/s: what the gyro says, and what
// the left pictures say.
struct RotationPair {
    Eigen::Vector3d gyro_imu = Eigen::Vector3d::Zero();
    Eigen::Vector3d vision_cam0 = Eigen::Vector3d::Zero();
};

// How well rotations agree with a mounting; medians, so that a few bad pairs do not matter. A
// constant gyro bias does not count. Residuals are relative to the motion: 0 fits, 1 does not.
struct HandEye {
    double motion = 0.0;              // rad/s, spread of the rates of vision
    double scale = 0.0;               // spread of the gyro's rates over that of vision's
    double given_residual = 0.0;      // with R_imu_cam0
    double inverse_residual = 0.0;    // with its transpose
    double best_residual = 0.0;       // with the rotation that fits best (Kabsch 1976)
    double best_angle_deg = 0.0;      // between that and R_imu_cam0
    bool best_is_determined = false;  // the motion turns about more than one axis
};

HandEye compare_rotations(const std::vector<RotationPair>& pairs,
                          const Eigen::Matrix3d& R_imu_cam0);

// Says so when T_BS is inverted or otherwise wrong, or the gyro in degrees. Too little motion says
// nothing.
void report_hand_eye(const std::vector<RotationPair>& pairs,
                     const Eigen::Matrix3d& R_imu_cam0,
                     FindingLog& findings);

}  // namespace divemesh::dive
