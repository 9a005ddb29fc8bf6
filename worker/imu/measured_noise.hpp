#pragma once

#include <vector>

#include "worker/types/recording.hpp"
#include "worker/types/rig.hpp"

namespace divemesh::imu {

// Returns the noise on a diver of an IMU with this data sheet: data sheets do not include thrusters
// and kicks.
types::ImuNoise on_a_diver(const types::ImuNoise& data_sheet);

// Returns `stated` with the white noise that the samples themselves show where that is larger: what
// thrusters, a loose mount, wrong units or rows left out add. It is measured by how far a
// sample lies from the line through its neighbours, to which a diver's motion hardly contributes at
// 100 Hz. Each second of samples counts once, and the median of the seconds is taken. As an error
// of interpolation shows in these distances too, samples that are too rare for the motion count as
// noisy ones. Fewer than 30 samples show nothing.
types::ImuNoise at_least_measured(const std::vector<types::ImuSample>& samples,
                                  const types::ImuNoise& stated);

}  // namespace divemesh::imu
