#pragma once

#include <Eigen/Core>
#include <array>

#include "worker/types/imu_alignment.hpp"
#include "worker/types/lens_change.hpp"

namespace divemesh::types {

// The calibration estimated from the whole dive, and which parts of it are applied.
struct RefinedCalibration {
    // The IMU; its sigmas are 0 without a gyroscope.
    ImuAlignment imu;
    double time_offset_sigma_s = 0.0;
    Eigen::Vector3d rotation_sigma_rad = Eigen::Vector3d::Zero();  // of q_body_imu, axes of body
    bool time_offset_applied = false;
    // Used where the estimate is not: the offset with which the dive was tracked.
    double tracked_time_offset_s = 0.0;
    bool rotation_applied = false;
    Eigen::Vector3d rate_error_sigma = Eigen::Vector3d::Zero();
    bool rate_error_applied = false;
    // The position of the IMU relative to the stated one, axes of imu.
    Eigen::Vector3d lever_arm_m = Eigen::Vector3d::Zero();
    Eigen::Vector3d lever_arm_sigma_m = Eigen::Vector3d::Zero();  // 0: not estimated
    bool lever_arm_applied = false;
    // The two lenses, left and right.
    std::array<LensChange, 2> lenses;
    std::array<LensChange::Vector, 2> lens_sigmas = {LensChange::Vector::Zero(),
                                                     LensChange::Vector::Zero()};
    double lens_shift_px = 0.0;  // RMS over the image of the shift by the lenses
    bool lenses_applied = false;
    // The shutter: the time from the first row of an image to the last; negative: upwards.
    double readout_time_s = 0.0;
    double readout_time_sigma_s = 0.0;  // 0: not estimated
    double readout_shift_px = 0.0;      // RMS over the features of the shift by it
    bool readout_time_applied = false;

    double applied_readout_time_s() const { return readout_time_applied ? readout_time_s : 0.0; }
    Eigen::Vector3d applied_lever_arm_m() const {
        return lever_arm_applied ? lever_arm_m : Eigen::Vector3d::Zero();
    }
    ImuAlignment applied_alignment() const {
        ImuAlignment applied;
        applied.time_offset_s = time_offset_applied ? imu.time_offset_s : tracked_time_offset_s;
        if (rotation_applied) applied.q_body_imu = imu.q_body_imu;
        if (rate_error_applied) applied.rate_error = imu.rate_error;
        return applied;
    }
    bool is_applied() const {
        return time_offset_applied || rotation_applied || rate_error_applied || lever_arm_applied ||
               lenses_applied || readout_time_applied;
    }
    // Keeps the estimates but applies none of them.
    void leave_as_stated() {
        time_offset_applied = rotation_applied = rate_error_applied = false;
        lever_arm_applied = false;
        lenses_applied = readout_time_applied = false;
    }
    // Returns false if there were no data to estimate it from.
    bool is_known() const { return lens_sigmas[0][0] > 0.0; }
};

}  // namespace divemesh::types
