#pragma once

#include <filesystem>
#include <memory>

#include "worker/geometry/rerectifier.hpp"
#include "worker/keyframe.hpp"

namespace divemesh::worker {

// Keyframe pictures and depth on disk, one file a keyframe, so that memory does not grow with the
// dive and every later stage can start from them. Disparity is kept to 1/128 px, sigma to 1/64 px,
// colour as JPEG. Any number of threads may read and write, each keyframe written by one.
class KeyframeStore {
public:
    explicit KeyframeStore(std::filesystem::path folder);  // made when missing
    // The same store; what is read is as if rectified with other lenses.
    KeyframeStore rerectified(std::shared_ptr<const KeyframeRerectifier> rerectifier) const;

    void clear() const;  // removes every file

    void write(int frame_index, const KeyframeImages& images) const;  // throws Error{OutOfSpace}
    KeyframeImages read(int frame_index) const;                       // throws Error{NotFound}
    cv::Mat read_left_color(int frame_index) const;                   // of the same, without depth

    // The left picture alone, grey, in a file of its own; as rectified while the dive was tracked.
    void write_left(int frame_index, const cv::Mat& left) const;
    cv::Mat read_left(int frame_index) const;

private:
    std::filesystem::path file_of(int frame_index, const char* extension) const;

    std::filesystem::path folder_;
    std::shared_ptr<const KeyframeRerectifier> rerectifier_;
};

}  // namespace divemesh::worker
