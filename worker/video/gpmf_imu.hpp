#pragma once

#include <vector>

#include "worker/types/recording.hpp"
#include "worker/video/gpmf.hpp"

namespace divemesh::video {

// The IMU of a video, by its telemetry.
struct GpmfImu {
    std::vector<types::ImuSample>
        samples;              // ascending; empty: it has no gyroscope or accelerometer
    bool is_damaged = false;  // a payload is damaged; what is before in it is used
};

// Returns a sample for each of the gyroscope, with the acceleration interpolated to its time. The
// format gives times to payloads alone, and a sensor's clock is steady where the writing of
// payloads is not, so samples lie on the line through the times of all payloads.
GpmfImu imu_of(const std::vector<GpmfPayload>& payloads);

}  // namespace divemesh::video
