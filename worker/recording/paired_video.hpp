#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "worker/recording/image_file.hpp"
#include "worker/video/plan_pairs.hpp"
#include "worker/video/video_reader.hpp"

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
    // `videos` are one, or two for VideoLayout::TwoFiles. Throws as VideoReader does.
    PairedVideo(const std::vector<std::filesystem::path>& videos,
                VideoLayout layout,
                const std::vector<video::PlannedPair>& plan);

    // Returns a pair of the plan, later than the last; nullopt if one of its frames is damaged.
    std::optional<VideoPair> at(const video::PlannedPair& pair);

private:
    VideoLayout layout_;
    std::unique_ptr<video::VideoReader> left_;
    std::unique_ptr<video::VideoReader> right_;  // nullptr: both are in the left one
};

// Returns a frame as a file: the JPEG that it is stored as, or a PNG of its pixels.
ImageFile image_file(const video::VideoFrame& frame);

}  // namespace divemesh::recording
