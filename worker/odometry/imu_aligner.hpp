#pragma once

#include <cstdint>
#include <vector>

#include "worker/imu/estimate_alignment.hpp"
#include "worker/imu/inertial_prior.hpp"
#include "worker/types/sensors_left_out.hpp"

namespace divemesh::odometry {

// An estimator of the IMU's time offset and misalignment in the first minute of a dive, so that the
// tracking does not use a prediction that is late or misaligned. Only significant values are
// applied; the bundle adjustment of the whole dive estimates them again.
class ImuAligner {
public:
    // Searches for time offsets near `time_offset_s`.
    explicit ImuAligner(const types::Recording& recording,
                        const types::SensorsLeftOut& left_out = {},
                        double time_offset_s = 0.0);

    // Adds a rotation by vision alone. Corrects `inertial` when the rotations so far are
    // significant: after two seconds, and whenever their number has grown by half.
    void watch(const imu::VisionMotion& motion, imu::InertialPrior& inertial);

    const types::ImuAlignment& alignment() const { return alignment_; }

private:
    double start_s_ = 0.0;  // time offset already taken out of the samples
    std::vector<types::ImuSample> samples_;
    std::vector<imu::VisionRotation> rotations_;
    std::size_t next_size_ = 40;
    types::ImuAlignment alignment_;
};

}  // namespace divemesh::odometry
