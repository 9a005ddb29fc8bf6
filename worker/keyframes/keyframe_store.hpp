#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "worker/camera/rerectifier.hpp"
#include "worker/camera/shutter_correction.hpp"
#include "worker/features/described_keypoints.hpp"
#include "worker/types/keyframe.hpp"

namespace divemesh::keyframes {

// The store on disk, one file each, of the depth of the mapped frames and of the grey images and
// keypoints of the keyframes, so that memory does not grow with the dive and every later stage can
// start from the store. Disparity is stored to 1/128 px, in frames with disparities of 512 px and
// more to 1/64 px (up to 1024 px), sigma to 1/64 px. Colour is read from the recording again:
// encoding and storing it here would cost more than decoding it twice.
// Thread-safe, if each frame is written by one thread only.
class KeyframeStore {
public:
    // Returns the rectified left image of a frame, CV_8UC3; must be thread-safe.
    using LeftInColor = std::function<cv::Mat(int frame_index)>;

    // Creates the folder if it is missing. Without `left_in_color` read() returns no image.
    explicit KeyframeStore(std::filesystem::path folder, LeftInColor left_in_color = {});
    // Returns the same store; its read() first moves images and depth to where an ideal pair shows
    // them, each pixel by its range. As it needs the depth, left_in_color() throws as read() does.
    KeyframeStore at_own_range(std::shared_ptr<const types::RangeTable> ranges) const;
    // Returns the same store; its read() maps images and depth as if rectified with other lenses.
    KeyframeStore rerectified(std::shared_ptr<const camera::KeyframeRerectifier> rerectifier) const;
    // Returns the same store; its read() then maps images and depth to a global shutter. As it
    // needs the depth, left_in_color() throws as read() does.
    KeyframeStore corrected(std::shared_ptr<const camera::ShutterCorrection> correction) const;

    void clear() const;  // removes all files

    void write(int frame_index, const types::DepthMap& depth) const;  // throws Error{OutOfSpace}
    types::KeyframeImages read(int frame_index) const;                // throws Error{NotFound}
    cv::Mat left_in_color(int frame_index) const;                     // the image of read() alone
    types::DepthMap read_depth(int frame_index) const;                // the depth of read() alone
    // Returns every step_px-th disparity of every step_px-th row (CV_32F, px), as matched: without
    // the maps of at_own_range(), rerectified() and corrected(). Reads these rows alone. Throws
    // Error{NotFound}.
    cv::Mat read_disparities(int frame_index, int step_px) const;

    // Write and read the grey left image in a file of its own, as rectified while the dive was
    // tracked.
    void write_left(int frame_index, const cv::Mat& left) const;
    cv::Mat read_left(int frame_index) const;

    // Write and read the keypoints by which a keyframe is recognised.
    void write_keypoints(int frame_index, const features::DescribedKeypoints& view) const;
    features::DescribedKeypoints read_keypoints(int frame_index) const;  // throws Error{BadData}

private:
    std::filesystem::path file_of(int frame_index, const char* extension) const;

    std::filesystem::path folder_;
    LeftInColor left_in_color_;
    std::shared_ptr<const types::RangeTable> ranges_;
    std::shared_ptr<const camera::KeyframeRerectifier> rerectifier_;
    std::shared_ptr<const camera::ShutterCorrection> correction_;
};

}  // namespace divemesh::keyframes
