#include "worker/imu/usable_samples.hpp"

namespace divemesh::imu {

std::vector<types::ImuSample> without(const std::vector<types::TimeInterval>& times,
                                      const std::vector<types::ImuSample>& samples) {
    std::vector<types::ImuSample> result = samples;
    for (const types::TimeInterval& time : times)
        std::erase_if(result, [&](const types::ImuSample& sample) {
            return time.from_ns <= sample.timestamp_ns && sample.timestamp_ns <= time.to_ns;
        });
    return result;
}

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

}  // namespace divemesh::imu
