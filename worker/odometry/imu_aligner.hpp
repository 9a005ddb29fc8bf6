#pragma once

#include <cstdint>
#include <vector>

#include "worker/imu/estimate_alignment.hpp"
#include "worker/imu/inertial_prior.hpp"
#include "worker/odometry/register_points.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::odometry {

// Watches the first minute of a dive for a time offset and a misalignment of the inertial unit, so
// that the tracking does not lean on a prediction that is always late or askew. What is not plainly
// there is left alone; the adjustment of the whole dive looks again.
class ImuAligner {
public:
    explicit ImuAligner(const types::Recording& recording) : samples_(recording.imu()) {}

    // `vision` saw the camera move over the interval; of `measured`, pairs as the two frames alone
    // have them, its inliers count. (Landmarks will not do for that: the window places them with
    // the very gyroscope that is judged here, and an error of it would confirm itself.) Changes
    // `inertial` when the turns so far say so: after two seconds, and whenever there are half as
    // many turns again.
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
