#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "worker/recording/image_file.hpp"
#include "worker/video/joined_reader.hpp"
#include "worker/video/plan_pairs.hpp"

namespace divemesh::recording {

// Where the images of both cameras are.
enum class VideoLayout {
    TwoFiles,
    SideBySide,  // left and right half of one video
    OverUnder,   // upper half: left camera; lower half: right camera
};

// The images of a pair as files of a dive, or as pixels that are still to be written.
struct VideoPair {
    video::PlannedPair times;
    video::VideoFrame left;
    video::VideoFrame right;
};

// Reads pairs of one video or two.
class PairedVideo {
public:
    // `videos` are one, or two for VideoLayout::TwoFiles. Throws as JoinedReader does.
    PairedVideo(const std::vector<video::IndexedVideo>& videos,
                VideoLayout layout,
                const std::vector<video::PlannedPair>& plan);

    // Returns a pair of the plan, later than the last; nullopt if one of its frames is damaged.
    // Throws as JoinedReader does.
    std::optional<VideoPair> at(const video::PlannedPair& pair);

private:
    VideoLayout layout_;
    std::unique_ptr<video::JoinedReader> left_;
    std::unique_ptr<video::JoinedReader> right_;  // nullptr: both are in the left one
};

// Returns a frame as a file: the JPEG that it is stored as, or a PNG of its pixels.
ImageFile image_file(const video::VideoFrame& frame);

}  // namespace divemesh::recording
