#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "worker/types/imu_alignment.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::imu {

// What a unit that sits as calibrated would have said, on the cameras' clock.
std::vector<types::ImuSample> aligned(const std::vector<types::ImuSample>& samples,
                                      const types::ImuAlignment& alignment);
std::vector<types::OrientationSample> aligned(const std::vector<types::OrientationSample>& samples,
                                              const types::ImuAlignment& alignment);

// A turn of the body that the pictures alone saw, on their clock.
struct VisionRotation {
    std::int64_t from_ns = 0;
    std::int64_t to_ns = 0;
    Eigen::Quaterniond q_from_to = Eigen::Quaterniond::Identity();
};

struct AlignmentEstimate {
    types::ImuAlignment alignment;
    double time_offset_sigma_s = 0.0;
    Eigen::Matrix3d rotation_covariance = Eigen::Matrix3d::Zero();  // of q_body_imu, in body, rad^2
    Eigen::Vector3d gyroscope_bias_body = Eigen::Vector3d::Zero();  // rad/s

    bool time_offset_is_significant() const;
    bool rotation_is_significant() const;
};

// Time offset, misalignment and bias of the gyroscope that bring it together best with what the
// pictures saw: least squares over the turns,
//
//     log(q_seen) = R_body_imu log(q_gyroscope(from + dt, to + dt)) - b (to - from)
//
// started from the best of a row of offsets to 60 ms either way, with Huber weights and priors
// (30 ms, 2 degrees, 0.1 rad/s). A row of turns about one axis leaves the rotation about that axis
// to its prior. Nothing when fewer than 20 turns are covered by the samples.
std::optional<AlignmentEstimate> estimate_alignment(const std::vector<types::ImuSample>& samples,
                                                    const std::vector<VisionRotation>& rotations);

}  // namespace divemesh::imu
