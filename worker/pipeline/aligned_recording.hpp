#pragma once

#include <optional>
#include <vector>

#include "worker/types/recording.hpp"

namespace divemesh::pipeline {

// A recording whose stated rig may be replaced by the one estimated from its images, and whose
// images may be read at a reduced size. Everything else is as recorded.
class AlignedRecording : public types::Recording {
public:
    explicit AlignedRecording(types::Recording& recording);

    // Must not be called while another thread reads. `rig` is that of the images as recorded.
    void set_rig(const types::Rig& rig);
    // Must not be called while another thread reads. All images have 1 / `reduction` of their size
    // from now on.
    void set_reduction(int reduction);

    int reduction() const { return reduction_; }
    // Returns the rig of the images as recorded.
    const types::Rig& recorded_rig() const { return recorded_rig_; }

    // Returns the rig of the images as they are read.
    const types::Rig& rig() const override { return rig_; }
    int num_frames() const override { return recording_.num_frames(); }
    const std::vector<types::ImuSample>& imu() const override { return recording_.imu(); }
    const std::vector<types::OrientationSample>& ahrs() const override { return recording_.ahrs(); }
    const std::vector<types::PressureSample>& pressure() const override {
        return recording_.pressure();
    }
    const cv::Mat& fixed_pattern() const override { return fixed_pattern_; }
    std::optional<types::StereoFrame> next_frame() override {
        return reduced(recording_.next_frame());
    }
    std::optional<types::StereoFrame> frame(int index) const override {
        return reduced(recording_.frame(index));
    }
    cv::Mat left_in_color(int frame_index, int reduction) const override {
        return reduced(recording_.left_in_color(frame_index, reduction));
    }
    void rewind() override { recording_.rewind(); }
    std::int64_t num_skipped_frames() const override { return recording_.num_skipped_frames(); }

private:
    cv::Mat reduced(const cv::Mat& image) const;
    std::optional<types::StereoFrame> reduced(std::optional<types::StereoFrame> frame) const;

    types::Recording& recording_;
    types::Rig recorded_rig_;
    int reduction_ = 1;
    types::Rig rig_;
    cv::Mat fixed_pattern_;
};

}  // namespace divemesh::pipeline
