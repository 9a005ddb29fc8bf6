#include "worker/imu/usable_samples.hpp"

namespace divemesh::imu {

std::vector<types::ImuSample> usable_rates(const types::Recording& recording,
                                           const types::SensorsLeftOut& left_out) {
    if (left_out.imu) return {};
    return without(left_out.imu_times, recording.imu());
}

std::vector<types::ImuSample> usable_forces(const types::Recording& recording,
                                            const types::SensorsLeftOut& left_out) {
    if (left_out.accelerometer) return {};
    return usable_rates(recording, left_out);
}

std::vector<types::OrientationSample> usable_orientations(const types::Recording& recording,
                                                          const types::SensorsLeftOut& left_out) {
    if (left_out.ahrs) return {};
    return without(left_out.ahrs_times, recording.ahrs());
}

}  // namespace divemesh::imu
