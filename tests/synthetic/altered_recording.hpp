#pragma once

#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "worker/types/recording.hpp"

namespace divemesh::synthetic {

// A recording that passes every frame through `alter` before it returns it.
class AlteredRecording : public types::Recording {
public:
    using Alter = std::function<void(types::StereoFrame&)>;

    AlteredRecording(types::Recording& recording, Alter alter)
        : recording_(recording), alter_(std::move(alter)) {}

    const types::Rig& rig() const override { return recording_.rig(); }
    int num_frames() const override { return recording_.num_frames(); }
    const std::vector<types::ImuSample>& imu() const override { return recording_.imu(); }
    const std::vector<types::OrientationSample>& ahrs() const override { return recording_.ahrs(); }
    const std::vector<types::PressureSample>& pressure() const override {
        return recording_.pressure();
    }
    const cv::Mat& fixed_pattern() const override { return recording_.fixed_pattern(); }
    std::optional<types::StereoFrame> frame(int index) const override {
        auto frame = recording_.frame(index);
        if (frame) alter_(*frame);
        return frame;
    }
    cv::Mat left_in_color(int frame_index, int reduction) const override {
        return recording_.left_in_color(frame_index, reduction);
    }
    void rewind() override { recording_.rewind(); }
    std::int64_t num_skipped_frames() const override { return recording_.num_skipped_frames(); }
    std::optional<types::StereoFrame> next_frame() override {
        auto frame = recording_.next_frame();
        if (frame) alter_(*frame);
        return frame;
    }

private:
    types::Recording& recording_;
    Alter alter_;
};

}  // namespace divemesh::synthetic
