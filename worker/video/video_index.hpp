#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "worker/base/observer.hpp"
#include "worker/video/gpmf.hpp"
#include "worker/video/video_file.hpp"

namespace divemesh::video {

// What a pass over a video without decoding shows.
struct VideoIndex {
    VideoTraits traits;
    std::vector<std::int64_t> stamps_ns;  // of its frames, ascending
    std::int64_t num_repeated = 0;        // frames with the stamp of another one
    std::int64_t num_unstamped = 0;
    bool is_cut = false;  // it ends before it states
    std::vector<GpmfPayload> gpmf;

    double period_s() const;  // median between frames; 0: fewer than two
};

// Throws as VideoFile does, Error{BadData} if it holds no frame, and Error{TooLarge} if it holds
// more frames or telemetry than any camera records in a week.
VideoIndex read_index(const std::filesystem::path& path, const base::ProgressCallback& progress);

// Throws Error{TooLarge}, which names the file that was read last, as read_index() does.
void check_size(const VideoIndex& index, const std::filesystem::path& path);

}  // namespace divemesh::video
