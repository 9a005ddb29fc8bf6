#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "worker/video/indexed_video.hpp"
#include "worker/video/video_reader.hpp"

namespace divemesh::video {

// Decodes chosen frames of a video that is one file or several, one file at a time.
class JoinedReader {
public:
    // `stamps_ns` are some of the video's, ascending. Throws as VideoReader does.
    JoinedReader(std::vector<VideoPart> parts,
                 std::vector<std::int64_t> stamps_ns,
                 StoredJpeg stored_jpeg);

    // Returns a chosen frame that is later than the last one asked for; nullopt if it is damaged.
    // Throws as VideoReader does where a further file begins.
    std::optional<VideoFrame> at(std::int64_t stamp_ns);

private:
    std::size_t part_of(std::int64_t stamp_ns) const;
    void open(std::size_t part);

    std::vector<VideoPart> parts_;
    std::vector<std::int64_t> stamps_ns_;
    StoredJpeg stored_jpeg_;
    std::size_t opened_ = 0;
    std::optional<VideoReader> reader_;
};

}  // namespace divemesh::video
