#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "worker/base/observer.hpp"
#include "worker/dive/finding_log.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::dive {

// Collects properties of a dive's images as a whole: brightness, and the frame for the thumbnail.
class ImageSurvey {
public:
    explicit ImageSurvey(int num_frames) : middle_(num_frames / 2) {}

    void add(const types::StereoFrame& frame);
    // Reports findings on all images; call it after the last frame.
    void report(std::int64_t num_frames, FindingLog& findings) const;
    // Returns the index of the frame nearest to the middle of the dive; nullopt without frames.
    std::optional<int> middle_frame() const { return nearest_; }
    std::int64_t num_frames() const { return num_frames_; }

private:
    int middle_;
    std::int64_t num_frames_ = 0;
    std::int64_t num_black_left_ = 0;
    std::int64_t num_black_right_ = 0;
    std::optional<int> nearest_;  // so far
};

// Reads the rest of a recording. Reports `frames_done` and `fraction` to `progress`.
ImageSurvey survey_images(types::Recording& recording, const base::ProgressCallback& progress);

// Returns a JPEG, 320 px wide.
std::string thumbnail_jpeg(const cv::Mat& image);

}  // namespace divemesh::dive
