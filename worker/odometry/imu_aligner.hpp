#pragma once

#include <cstdint>
#include <vector>

#include "worker/imu/estimate_alignment.hpp"
#include "worker/imu/inertial_prior.hpp"
#include "worker/odometry/register_points.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::odometry {

// An estimator of the IMU's time offset and misalignment in the first minute of a dive, so that the
// tracking does not use a prediction that is late or misaligned. Only significant values are
// applied; the bundle adjustment of the whole dive estimates them again.
class ImuAligner {
public:
    explicit ImuAligner(const types::Recording& recording) : samples_(recording.imu()) {}

    // Adds the rotation over the interval by the inliers of `vision` among `measured`, pairs as
    // measured by the two frames alone. (Landmarks would not do: the sliding window places them
    // with the same gyroscope, so its error would confirm itself.) Corrects `inertial` when the
    // rotations so far are significant: after two seconds, and whenever their number has grown by
    // half.
    void watch(const types::RectifiedRig& rig,
               const PointPairs& measured,
               const Registration& vision,
               std::int64_t before_ns,
               std::int64_t now_ns,
               imu::InertialPrior& inertial);

    const types::ImuAlignment& alignment() const { return alignment_; }

private:
    const std::vector<types::ImuSample>& samples_;
    std::vector<imu::VisionRotation> rotations_;
    std::size_t next_size_ = 40;
    types::ImuAlignment alignment_;
};

}  // namespace divemesh::odometry
