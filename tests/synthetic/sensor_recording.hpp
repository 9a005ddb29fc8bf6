#pragma once

#include <optional>
#include <vector>

#include "worker/types/recording.hpp"

namespace divemesh::synthetic {

// A recording of inertial sensors and pressure, without images.
struct SensorRecording : types::Recording {
    types::Rig its_rig;
    std::vector<types::ImuSample> its_imu;
    std::vector<types::OrientationSample> its_ahrs;
    std::vector<types::PressureSample> its_pressure;
    cv::Mat its_fixed_pattern;

    const types::Rig& rig() const override { return its_rig; }
    int num_frames() const override { return 0; }
    const std::vector<types::ImuSample>& imu() const override { return its_imu; }
    const std::vector<types::OrientationSample>& ahrs() const override { return its_ahrs; }
    const std::vector<types::PressureSample>& pressure() const override { return its_pressure; }
    const cv::Mat& fixed_pattern() const override { return its_fixed_pattern; }
    std::optional<types::StereoFrame> next_frame() override { return std::nullopt; }
    std::optional<types::StereoFrame> frame(int) const override { return std::nullopt; }
    cv::Mat left_in_color(int, int) const override { return {}; }
    void rewind() override {}
    std::int64_t num_skipped_frames() const override { return 0; }
};

}  // namespace divemesh::synthetic
