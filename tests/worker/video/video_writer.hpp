#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "worker/video/libav.hpp"

namespace divemesh::video {

// What a video for a test is written with, by FFmpeg's own writers.
struct WrittenVideo {
    std::string codec = "ffv1";
    std::string pixel_format = "bgr0";  // "gray", "yuv420p" ...
    int width_px = 64;
    int height_px = 48;
    int ticks_hz = 1000;  // of the stamps
    int rate_hz = 30;     // that the encoder is told
    int max_b_frames = 0;
    int rotation_deg = 0;  // clockwise, that is to be done by what shows it
    bool is_mirrored = false;
    bool is_interlaced = false;
    std::map<std::string, std::string> encoder_options;
    std::map<std::string, std::string> muxer_options;
    std::string creation_time;
    std::string timecode;
    std::string audio_codec;  // "": no sound
    int audio_rate_hz = 48000;
    bool has_gpmf = false;
};

class VideoWriter {
public:
    // The name's extension chooses the format. Throws std::runtime_error.
    VideoWriter(const std::filesystem::path& path, const WrittenVideo& video);
    ~VideoWriter();
    VideoWriter(const VideoWriter&) = delete;
    VideoWriter& operator=(const VideoWriter&) = delete;

    // Adds an image, 8 bit grey or BGR, at a time in ticks.
    void add_frame(const cv::Mat& image, std::int64_t ticks);
    // Adds all of the sound, within -1 to 1, from 0 on.
    void add_sound(const std::vector<float>& samples);
    void add_gpmf(const std::string& payload, std::int64_t stamp_ms, std::int64_t duration_ms);
    void finish();

private:
    void open_video();
    void open_audio();
    void open_gpmf();
    void encode(AVCodecContext& codec, AVStream& stream, const AVFrame* frame);

    WrittenVideo video_;
    std::string path_;
    AVFormatContext* format_ = nullptr;
    AVStream* video_stream_ = nullptr;
    AVStream* audio_stream_ = nullptr;
    AVStream* gpmf_stream_ = nullptr;
    CodecHandle video_codec_;
    CodecHandle audio_codec_;
    ScalerHandle scaler_;
};

}  // namespace divemesh::video
