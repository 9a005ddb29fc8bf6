#pragma once

#include <utility>

#include "worker/types/recording.hpp"

namespace divemesh::pipeline {

// A recording whose stated rig may be replaced by the one that its images tell. All else stays.
class AlignedRecording : public types::Recording {
public:
    explicit AlignedRecording(types::Recording& recording)
        : recording_(recording), rig_(recording.rig()) {}

    // Must not be called while another thread reads.
    void set_rig(types::Rig rig) { rig_ = std::move(rig); }

    const types::Rig& rig() const override { return rig_; }
    int num_frames() const override { return recording_.num_frames(); }
    const std::vector<types::ImuSample>& imu() const override { return recording_.imu(); }
    const std::vector<types::OrientationSample>& ahrs() const override { return recording_.ahrs(); }
    const std::vector<types::PressureSample>& pressure() const override {
        return recording_.pressure();
    }
    const cv::Mat& fixed_pattern() const override { return recording_.fixed_pattern(); }
    std::optional<types::StereoFrame> next_frame() override { return recording_.next_frame(); }
    std::optional<types::StereoFrame> frame(int index) const override {
        return recording_.frame(index);
    }
    cv::Mat left_in_color(int frame_index) const override {
        return recording_.left_in_color(frame_index);
    }
    void rewind() override { recording_.rewind(); }
    std::int64_t num_skipped_frames() const override { return recording_.num_skipped_frames(); }

private:
    types::Recording& recording_;
    types::Rig rig_;
};

}  // namespace divemesh::pipeline
