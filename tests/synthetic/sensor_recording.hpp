#pragma once

#include <optional>
#include <vector>

#include "worker/types/recording.hpp"

namespace divemesh::synthetic {

// A recording of inertial sensors alone: no picture in it.
struct SensorRecording : worker::Recording {
    worker::Rig its_rig;
    std::vector<worker::ImuSample> its_imu;
    std::vector<worker::OrientationSample> its_ahrs;
    std::vector<worker::PressureSample> its_pressure;

    const worker::Rig& rig() const override { return its_rig; }
    int num_frames() const override { return 0; }
    const std::vector<worker::ImuSample>& imu() const override { return its_imu; }
    const std::vector<worker::OrientationSample>& ahrs() const override { return its_ahrs; }
    const std::vector<worker::PressureSample>& pressure() const override { return its_pressure; }
    std::optional<worker::StereoFrame> next_frame() override { return std::nullopt; }
    cv::Mat left_in_color(int) const override { return {}; }
    void rewind() override {}
    std::int64_t num_skipped_frames() const override { return 0; }
};

}  // namespace divemesh::synthetic
