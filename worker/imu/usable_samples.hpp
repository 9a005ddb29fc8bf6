#pragma once

#include <vector>

#include "worker/types/recording.hpp"
#include "worker/types/sensors_left_out.hpp"

namespace divemesh::imu {

// Returns the samples outside the times.
template <typename Sample>
std::vector<Sample> without(const std::vector<types::TimeInterval>& times,
                            std::vector<Sample> samples) {
    for (const types::TimeInterval& time : times)
        std::erase_if(samples, [&](const Sample& sample) {
            return time.from_ns <= sample.timestamp_ns && sample.timestamp_ns <= time.to_ns;
        });
    return samples;
}

// Return the samples of the dive's IMU, on its own clock, whose angular velocity or whose specific
// force may be used: samples that contradict the images are left out. Only the code that judges the
// IMU reads the samples from the recording itself.
std::vector<types::ImuSample> usable_rates(const types::Recording& recording,
                                           const types::SensorsLeftOut& left_out);
std::vector<types::ImuSample> usable_forces(const types::Recording& recording,
                                            const types::SensorsLeftOut& left_out);
// Likewise, of the dive's AHRS.
std::vector<types::OrientationSample> usable_orientations(const types::Recording& recording,
                                                          const types::SensorsLeftOut& left_out);

}  // namespace divemesh::imu
