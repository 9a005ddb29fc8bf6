#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "worker/types/imu_alignment.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::imu {

// Return the samples as an IMU mounted as calibrated would have measured them, on the cameras'
// clock.
std::vector<types::ImuSample> aligned(const std::vector<types::ImuSample>& samples,
                                      const types::ImuAlignment& alignment);
std::vector<types::OrientationSample> aligned(const std::vector<types::OrientationSample>& samples,
                                              const types::ImuAlignment& alignment);

// A rotation of the body measured by vision alone, on the cameras' clock.
struct VisionRotation {
    std::int64_t from_ns = 0;
    std::int64_t to_ns = 0;
    Eigen::Quaterniond q_from_to = Eigen::Quaterniond::Identity();
};

// A motion of the body measured by vision alone, on the cameras' clock.
struct VisionMotion {
    std::int64_t from_ns = 0;
    std::int64_t to_ns = 0;
    Eigen::Isometry3d T_from_to = Eigen::Isometry3d::Identity();

    VisionRotation rotation() const {
        return {from_ns, to_ns, Eigen::Quaterniond(T_from_to.linear())};
    }
};

// The estimated alignment with its uncertainty. A value is significant above four sigmas and a min
// size.
struct AlignmentEstimate {
    types::ImuAlignment alignment;
    double time_offset_sigma_s = 0.0;
    Eigen::Matrix3d rotation_covariance = Eigen::Matrix3d::Zero();  // of q_body_imu, in body, rad^2
    Eigen::Vector3d gyroscope_bias_body = Eigen::Vector3d::Zero();  // rad/s

    bool time_offset_is_significant() const;
    bool rotation_is_significant() const;
};

// Returns the time offset, misalignment and gyroscope bias that best agree with the rotations from
// vision: least squares over the rotations,
//
//     log(q_seen) = R_body_imu log(q_gyroscope(from + dt, to + dt)) - b (to - from)
//
// started from the best of a series of offsets within +-70 ms, with Huber weights and priors (30
// ms, 2 degrees, 0.1 rad/s). If all rotations share one axis, the misalignment about that axis
// stays at its prior. nullopt if the samples cover fewer than 20 rotations, if these are so small
// that noise would be taken for motion, or if the last of eight steps still moved offset or
// rotation by more than their standard deviation.
std::optional<AlignmentEstimate> estimate_alignment(const std::vector<types::ImuSample>& samples,
                                                    const std::vector<VisionRotation>& rotations);

}  // namespace divemesh::imu
