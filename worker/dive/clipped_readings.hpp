#pragma once

#include <cstddef>
#include <vector>

#include "worker/types/recording.hpp"

namespace divemesh::dive {

// The readings of one sensor of an IMU that stop at the end of its range.
struct ClippedReadings {
    std::vector<std::size_t> rows;  // ascending; empty: none
    double limit = 0.0;             // the min reading at which an axis stops, absolute

    // Returns true if so many readings are clipped that the sensor cannot be used.
    bool spoil(std::size_t num_rows) const;
};

// Return the readings of a gyroscope (rad/s) or an accelerometer (m/s^2) that are clipped: an axis
// stays at its largest or smallest value for several rows, and is hardly ever one step before it.
ClippedReadings clipped_rates(const std::vector<types::ImuSample>& samples);
ClippedReadings clipped_forces(const std::vector<types::ImuSample>& samples);

}  // namespace divemesh::dive
