#pragma once

#include <Eigen/Core>
#include <vector>

#include "worker/dive/finding_log.hpp"

namespace divemesh::dive {

// The rotation of the rig over a short time, as mean rates in rad/s, from the gyro and from the
// left images.
struct RotationPair {
    Eigen::Vector3d gyro_imu = Eigen::Vector3d::Zero();
    Eigen::Vector3d vision_cam0 = Eigen::Vector3d::Zero();
};

// How well rotations agree with a mounting; medians, so that a few bad pairs do not matter. A
// constant gyro bias has no effect. Residuals are relative to the motion: 0 is a perfect fit, 1 is
// no fit.
struct HandEye {
    double motion = 0.0;            // rad/s, spread of the rates from vision
    double scale = 0.0;             // spread of the gyro's rates over that of the rates from vision
    double given_residual = 0.0;    // with R_imu_cam0
    double inverse_residual = 0.0;  // with its transpose
    double best_residual = 0.0;     // with the best-fitting rotation (Kabsch 1976)
    double best_angle_deg = 0.0;    // between the best-fitting rotation and R_imu_cam0
    bool best_is_determined = false;  // the motion has more than one rotation axis
};

// Compares the rates of gyro and vision under the mounting R_imu_cam0.
HandEye compare_rotations(const std::vector<RotationPair>& pairs,
                          const Eigen::Matrix3d& R_imu_cam0);

// Reports a T_BS that is inverted or otherwise wrong, and a gyro in degrees. Reports nothing if
// there is too little motion.
void report_hand_eye(const std::vector<RotationPair>& pairs,
                     const Eigen::Matrix3d& R_imu_cam0,
                     FindingLog& findings);

}  // namespace divemesh::dive
