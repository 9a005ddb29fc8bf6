#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "worker/dive/finding_log.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::dive {

// What the pictures of a dive look like as a whole: brightness, and one for the thumbnail.
class ImageSurvey {
public:
    explicit ImageSurvey(int num_frames) : middle_(num_frames / 2) {}

    void add(const types::StereoFrame& frame);
    // Findings on the whole; after the last frame.
    void report(std::int64_t num_frames, FindingLog& findings) const;
    // Of the frame nearest to the middle of the dive; nothing without a frame.
    std::optional<int> middle_frame() const { return nearest_; }
    std::int64_t num_frames() const { return num_frames_; }

private:
    int middle_;
    std::int64_t num_frames_ = 0;
    std::int64_t num_black_left_ = 0;
    std::int64_t num_black_right_ = 0;
    std::optional<int> nearest_;  // so far
};

// 320 px wide.
std::string thumbnail_jpeg(const cv::Mat& image);

}  // namespace divemesh::dive
