#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "worker/camera/rerectifier.hpp"
#include "worker/features/described_keypoints.hpp"
#include "worker/types/keyframe.hpp"

namespace divemesh::keyframes {

// Depth of the mapped frames, grey pictures of the keyframes and what these are recognised by on
// disk, one file each, so that memory does not grow with the dive and every later stage can start
// from them. Disparity is kept
// to 1/128 px, sigma to 1/64 px. Colour comes from the recording again, as it is there: to encode
// and keep it here would cost more than to decode it twice. Any number of threads may read and
// write, each frame written by one.
class KeyframeStore {
public:
    // The left picture of a frame, rectified, CV_8UC3; any thread.
    using LeftInColor = std::function<cv::Mat(int frame_index)>;

    // The folder is made when missing. Without `left_in_color` what is read has no picture.
    explicit KeyframeStore(std::filesystem::path folder, LeftInColor left_in_color = {});
    // The same store; what is read is as if rectified with other lenses.
    KeyframeStore rerectified(std::shared_ptr<const camera::KeyframeRerectifier> rerectifier) const;

    void clear() const;  // removes every file

    void write(int frame_index, const types::DepthMap& depth) const;  // throws Error{OutOfSpace}
    types::KeyframeImages read(int frame_index) const;                // throws Error{NotFound}
    cv::Mat left_in_color(int frame_index) const;                     // of the same, without depth

    // The left picture alone, grey, in a file of its own; as rectified while the dive was tracked.
    void write_left(int frame_index, const cv::Mat& left) const;
    cv::Mat read_left(int frame_index) const;

    // What a keyframe is recognised by.
    void write_keypoints(int frame_index, const features::DescribedKeypoints& view) const;
    features::DescribedKeypoints read_keypoints(int frame_index) const;  // throws Error{BadData}

private:
    std::filesystem::path file_of(int frame_index, const char* extension) const;

    std::filesystem::path folder_;
    LeftInColor left_in_color_;
    std::shared_ptr<const camera::KeyframeRerectifier> rerectifier_;
};

}  // namespace divemesh::keyframes
