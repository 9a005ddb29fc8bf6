#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "worker/video/libav.hpp"

namespace divemesh::video {

// The longest recording that is read, and how far from 0 a stamp may be: 115 days.
inline constexpr std::int64_t kMaxStamp_ns = 10'000'000'000'000'000;

// Returns whether a file begins as MP4, MOV, MKV or AVI do; 12 bytes are enough.
bool is_video(std::string_view head);

// What a video file states about itself.
struct VideoTraits {
    std::string codec;          // "h264"
    std::int64_t width_px = 0;  // as recorded, before it is turned upright
    std::int64_t height_px = 0;
    int rotation_deg = 0;  // clockwise, a multiple of 90: what turns it upright
    bool is_interlaced = false;
    double rate_hz = 0.0;                     // mean; 0: not known
    double duration_s = 0.0;                  // 0: not stated
    std::optional<std::int64_t> creation_ns;  // since 1970
    bool has_fine_creation = false;           // to less than a second
    std::optional<double> timecode_s;         // of its first frame, since midnight
    bool has_audio = false;
    bool has_gpmf = false;

    std::int64_t upright_width_px() const { return rotation_deg % 180 ? height_px : width_px; }
    std::int64_t upright_height_px() const { return rotation_deg % 180 ? width_px : height_px; }
};

// A video file, read packet by packet. It reads no other file and no network, whatever the file
// refers to.
class VideoFile {
public:
    // Throws Error{NotFound} or Error{Unavailable} if the file cannot be opened, Error{BadData}
    // with the reason if it is no video, or is one that is not read.
    explicit VideoFile(std::filesystem::path path);

    const std::filesystem::path& path() const { return path_; }
    const VideoTraits& traits() const { return traits_; }
    // nullptr: there is none
    const AVStream* video() const { return video_; }
    const AVStream* audio() const { return audio_; }
    const AVStream* gpmf() const { return gpmf_; }

    // Reads packets of these streams alone.
    void read_only(std::initializer_list<const AVStream*> streams);
    // Reads the next packet; returns false at the end, or where the rest cannot be read.
    bool next(AVPacket& packet);
    // Returns whether reading ended before the file does.
    bool is_broken() const { return is_broken_; }

private:
    void find_streams();
    void read_traits();
    void read_clocks();

    std::filesystem::path path_;
    FormatHandle format_;
    const AVStream* video_ = nullptr;
    const AVStream* audio_ = nullptr;
    const AVStream* gpmf_ = nullptr;
    VideoTraits traits_;
    bool is_broken_ = false;
};

// Returns when a packet or frame of a stream is shown; nullopt if it states none that can be.
std::optional<std::int64_t> stamp_ns(std::int64_t ticks, const AVStream& stream);
std::optional<std::int64_t> stamp_ns(const AVPacket& packet, const AVStream& stream);

}  // namespace divemesh::video
