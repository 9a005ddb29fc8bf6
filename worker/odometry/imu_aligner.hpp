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
    // Starts with an alignment that an earlier attempt learnt from `num_known` rotations (0: none)
    // and searches for time offsets near its own. As many or fewer rotations do not change it: the
    // first seconds of a slow dive may tell the same wrong offset whenever they are asked.
    explicit ImuAligner(const types::Recording& recording,
                        const types::SensorsLeftOut& left_out = {},
                        const types::ImuAlignment& start = {},
                        std::size_t num_known = 0);

    // Adds a rotation by vision alone. Corrects `inertial` when the rotations so far are
    // significant: after two seconds, and whenever their number has grown by half.
    void watch(const imu::VisionMotion& motion, imu::InertialPrior& inertial);

    const types::ImuAlignment& alignment() const { return alignment_; }
    // Returns how many rotations told it.
    std::size_t num_rotations() const { return num_known_; }

private:
    double start_s_ = 0.0;  // time offset already taken out of the samples
    std::size_t num_known_ = 0;
    std::vector<types::ImuSample> samples_;
    std::vector<imu::VisionRotation> rotations_;
    std::size_t next_size_ = 40;
    types::ImuAlignment alignment_;
};

}  // namespace divemesh::odometry
