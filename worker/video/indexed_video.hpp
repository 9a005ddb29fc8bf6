#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "worker/video/video_index.hpp"

namespace divemesh::video {

// A file of a recording, and where its times are in those of the whole.
struct VideoPart {
    std::filesystem::path path;
    std::int64_t offset_ns = 0;  // added to the file's stamps
    std::int64_t first_ns = 0;   // of its first frame, in the whole
};

// A video with what its index shows: one file, or chapters that follow each other.
struct IndexedVideo {
    std::vector<VideoPart> parts;
    VideoIndex index;

    // Returns the name of the first file.
    std::string name() const { return parts.front().path.filename().string(); }
};

// Returns a video of one file.
IndexedVideo one_file(const std::filesystem::path& path, VideoIndex index);

// Returns whether a chapter has images like those of the video before it.
bool continues(const IndexedVideo& video, const VideoIndex& chapter);

// Appends a chapter, whose times begin where those of the video before it end. Throws
// Error{TooLarge} as read_index() does.
void append_chapter(IndexedVideo& video, const std::filesystem::path& path, VideoIndex chapter);

}  // namespace divemesh::video
