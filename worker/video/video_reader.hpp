#pragma once

#include <cstdint>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <unordered_set>
#include <vector>

#include "worker/video/frame_converter.hpp"
#include "worker/video/video_file.hpp"

namespace divemesh::video {

// Whether a frame that is stored as JPEG stays so, or is decoded like every other.
enum class StoredJpeg { Kept, Decoded };

// A frame of a video, upright: its pixels, 8 bit grey or BGR, or the JPEG file that it is stored
// as.
struct VideoFrame {
    std::int64_t stamp_ns = 0;
    cv::Mat pixels;
    std::string jpeg;
};

// Decodes chosen frames of a video, in the order of their stamps. Frames that no chosen one needs
// are not decoded.
class VideoReader {
public:
    // `stamps_ns` are some of VideoIndex::stamps_ns. Throws as VideoFile and open_decoder() do.
    VideoReader(const std::filesystem::path& path,
                const std::vector<std::int64_t>& stamps_ns,
                StoredJpeg stored_jpeg);

    const VideoTraits& traits() const { return file_.traits(); }
    // Returns the next chosen frame; nullopt at the end. One that is damaged is left out.
    std::optional<VideoFrame> next();
    // Returns a chosen frame that is later than the last one asked for; nullopt if it is damaged.
    std::optional<VideoFrame> at(std::int64_t stamp_ns);

private:
    enum class Fed { Packet, End };

    std::optional<VideoFrame> decoded();
    Fed feed();
    bool is_chosen(std::int64_t stamp_ns) const { return chosen_.contains(stamp_ns); }
    std::optional<VideoFrame> stored_frame(const AVPacket& packet) const;

    VideoFile file_;
    StoredJpeg stored_jpeg_;
    std::unordered_set<std::int64_t> chosen_;  // that have not been returned
    CodecHandle codec_;
    PacketHandle packet_;
    FrameHandle frame_;
    FrameConverter converter_;
    std::optional<VideoFrame> stored_;  // was in the last packet
    std::optional<VideoFrame> ahead_;   // was read, and not asked for yet
    std::int64_t num_damaged_ = 0;
    bool is_drained_ = false;
};

}  // namespace divemesh::video
