#pragma once

#include <cstdint>
#include <vector>

namespace divemesh::types {

// A time on the cameras' clock, both ends included.
struct TimeInterval {
    std::int64_t from_ns = 0;
    std::int64_t to_ns = 0;
};

// What is left out of a dive's sensors because it contradicts the images.
struct SensorsLeftOut {
    bool imu = false;
    bool accelerometer = false;  // the gyroscope is used
    bool ahrs = false;
    bool pressure = false;
    // On the sensors' clock; they are used at all other times.
    std::vector<TimeInterval> imu_times;
    std::vector<TimeInterval> ahrs_times;
};

}  // namespace divemesh::types
