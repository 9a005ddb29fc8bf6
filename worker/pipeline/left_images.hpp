#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <future>
#include <map>
#include <mutex>
#include <opencv2/core/mat.hpp>

namespace divemesh::pipeline {

// The grey left images of frames, each read once as long as it is among the last `capacity` that
// were asked for. Thread-safe.
class LeftImages {
public:
    // Returns the rectified left image of a frame, CV_8UC3; must be thread-safe.
    using ReadColor = std::function<cv::Mat(int frame_index)>;

    LeftImages(ReadColor read, std::size_t capacity);

    // Returns the image, CV_8UC1. Rethrows what reading throws.
    cv::Mat grey(int frame_index);

private:
    const ReadColor read_;
    const std::size_t capacity_;
    std::mutex mutex_;
    std::map<int, std::shared_future<cv::Mat>> images_;
    std::deque<int> order_;  // of images_, the oldest first
};

}  // namespace divemesh::pipeline
