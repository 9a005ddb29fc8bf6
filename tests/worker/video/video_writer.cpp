#include "tests/worker/video/video_writer.hpp"

#include <cstring>
#include <stdexcept>

extern "C" {
#include <libavutil/channel_layout.h>
#include <libavutil/display.h>
#include <libavutil/opt.h>
#include <libavutil/pixdesc.h>
}

// Read by LeakSanitizer: the encoder of H.265 keeps a table until the process ends.
extern "C" const char* __lsan_default_suppressions() { return "leak:libx265\n"; }

namespace divemesh::video {
namespace {

int checked(int code, const char* what) {
    if (code < 0) throw std::runtime_error(std::string(what) + ": " + libav_text(code));
    return code;
}

template <typename Pointer>
Pointer checked(Pointer pointer, const char* what) {
    if (pointer == nullptr) throw std::runtime_error(what);
    return pointer;
}

const AVCodec* encoder(const std::string& name) {
    return checked(avcodec_find_encoder_by_name(name.c_str()), name.c_str());
}

void set_rotation(AVStream& stream, int rotation_deg, bool is_mirrored) {
    auto* matrix = reinterpret_cast<std::int32_t*>(
        av_stream_new_side_data(&stream, AV_PKT_DATA_DISPLAYMATRIX, 9 * sizeof(std::int32_t)));
    av_display_rotation_set(matrix, rotation_deg);
    if (is_mirrored) av_display_matrix_flip(matrix, 1, 0);
}

}  // namespace

VideoWriter::VideoWriter(const std::filesystem::path& path, const WrittenVideo& video)
    : video_(video), path_(path.string()) {
    av_log_set_level(AV_LOG_QUIET);
    checked(avformat_alloc_output_context2(&format_, nullptr, nullptr, path_.c_str()), "format");
    if (!video.creation_time.empty())
        av_dict_set(&format_->metadata, "creation_time", video.creation_time.c_str(), 0);
    open_video();
    if (!video.audio_codec.empty()) open_audio();
    if (video.has_gpmf) open_gpmf();
    checked(avio_open(&format_->pb, path_.c_str(), AVIO_FLAG_WRITE), "open");
    AVDictionary* options = nullptr;
    for (const auto& [key, value] : video.muxer_options)
        av_dict_set(&options, key.c_str(), value.c_str(), 0);
    checked(avformat_write_header(format_, &options), "header");
    av_dict_free(&options);
}

VideoWriter::~VideoWriter() {
    if (format_ != nullptr) avio_closep(&format_->pb);
    avformat_free_context(format_);
}

void VideoWriter::open_video() {
    const AVCodec* codec = encoder(video_.codec);
    video_codec_.reset(checked(avcodec_alloc_context3(codec), "codec"));
    video_codec_->width = video_.width_px;
    video_codec_->height = video_.height_px;
    video_codec_->pix_fmt = av_get_pix_fmt(video_.pixel_format.c_str());
    video_codec_->time_base = {1, video_.ticks_hz};
    video_codec_->framerate = {video_.rate_hz, 1};
    video_codec_->max_b_frames = video_.max_b_frames;
    video_codec_->thread_count = 1;
    video_codec_->strict_std_compliance = FF_COMPLIANCE_UNOFFICIAL;
    if (video_.is_interlaced) {
        video_codec_->flags |= AV_CODEC_FLAG_INTERLACED_DCT | AV_CODEC_FLAG_INTERLACED_ME;
        video_codec_->field_order = AV_FIELD_TT;
    }
    if ((format_->oformat->flags & AVFMT_GLOBALHEADER) != 0)
        video_codec_->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    AVDictionary* options = nullptr;
    for (const auto& [key, value] : video_.encoder_options)
        av_dict_set(&options, key.c_str(), value.c_str(), 0);
    checked(avcodec_open2(video_codec_.get(), codec, &options), "video encoder");
    av_dict_free(&options);
    video_stream_ = checked(avformat_new_stream(format_, nullptr), "stream");
    checked(avcodec_parameters_from_context(video_stream_->codecpar, video_codec_.get()), "stream");
    if (video_.is_interlaced) video_stream_->codecpar->field_order = AV_FIELD_TT;
    video_stream_->time_base = video_codec_->time_base;
    video_stream_->avg_frame_rate = video_codec_->framerate;
    if (!video_.timecode.empty())
        av_dict_set(&video_stream_->metadata, "timecode", video_.timecode.c_str(), 0);
    if (video_.rotation_deg != 0 || video_.is_mirrored)
        set_rotation(*video_stream_, video_.rotation_deg, video_.is_mirrored);
}

void VideoWriter::open_audio() {
    const AVCodec* codec = encoder(video_.audio_codec);
    audio_codec_.reset(checked(avcodec_alloc_context3(codec), "codec"));
    audio_codec_->sample_rate = video_.audio_rate_hz;
    audio_codec_->sample_fmt = codec->sample_fmts[0];
    audio_codec_->bit_rate = 128'000;
    av_channel_layout_default(&audio_codec_->ch_layout, 1);
    audio_codec_->time_base = {1, video_.audio_rate_hz};
    if ((format_->oformat->flags & AVFMT_GLOBALHEADER) != 0)
        audio_codec_->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    checked(avcodec_open2(audio_codec_.get(), codec, nullptr), "audio encoder");
    audio_stream_ = checked(avformat_new_stream(format_, nullptr), "stream");
    checked(avcodec_parameters_from_context(audio_stream_->codecpar, audio_codec_.get()), "stream");
    audio_stream_->time_base = audio_codec_->time_base;
}

void VideoWriter::open_gpmf() {
    gpmf_stream_ = checked(avformat_new_stream(format_, nullptr), "stream");
    gpmf_stream_->codecpar->codec_type = AVMEDIA_TYPE_DATA;
    gpmf_stream_->codecpar->codec_id = AV_CODEC_ID_BIN_DATA;
    gpmf_stream_->codecpar->codec_tag = MKTAG('g', 'p', 'm', 'd');
    gpmf_stream_->time_base = {1, 1000};
}

void VideoWriter::encode(AVCodecContext& codec, AVStream& stream, const AVFrame* frame) {
    checked(avcodec_send_frame(&codec, frame), "encode");
    const PacketHandle packet = new_packet();
    while (avcodec_receive_packet(&codec, packet.get()) >= 0) {
        packet->stream_index = stream.index;
        av_packet_rescale_ts(packet.get(), codec.time_base, stream.time_base);
        checked(av_interleaved_write_frame(format_, packet.get()), "write");
    }
}

void VideoWriter::add_frame(const cv::Mat& image, std::int64_t ticks) {
    const AVPixelFormat given = image.channels() == 1 ? AV_PIX_FMT_GRAY8 : AV_PIX_FMT_BGR24;
    scaler_.reset(sws_getContext(image.cols,
                                 image.rows,
                                 given,
                                 video_.width_px,
                                 video_.height_px,
                                 video_codec_->pix_fmt,
                                 SWS_BILINEAR | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INP,
                                 nullptr,
                                 nullptr,
                                 nullptr));
    const FrameHandle frame = new_frame();
    frame->format = video_codec_->pix_fmt;
    frame->width = video_.width_px;
    frame->height = video_.height_px;
    frame->pts = ticks;
    frame->interlaced_frame = video_.is_interlaced ? 1 : 0;
    frame->top_field_first = frame->interlaced_frame;
    checked(av_frame_get_buffer(frame.get(), 0), "frame");
    const std::uint8_t* rows[4] = {image.data, nullptr, nullptr, nullptr};
    const int row_bytes[4] = {static_cast<int>(image.step[0]), 0, 0, 0};
    sws_scale(scaler_.get(), rows, row_bytes, 0, image.rows, frame->data, frame->linesize);
    encode(*video_codec_, *video_stream_, frame.get());
}

void VideoWriter::add_sound(const std::vector<float>& samples) {
    const auto step =
        static_cast<std::size_t>(audio_codec_->frame_size > 0 ? audio_codec_->frame_size : 1024);
    for (std::size_t at = 0; at < samples.size(); at += step) {
        const std::size_t num = std::min(step, samples.size() - at);
        const FrameHandle frame = new_frame();
        frame->format = audio_codec_->sample_fmt;
        frame->nb_samples = static_cast<int>(num);
        frame->sample_rate = audio_codec_->sample_rate;
        av_channel_layout_copy(&frame->ch_layout, &audio_codec_->ch_layout);
        frame->pts = static_cast<std::int64_t>(at);
        checked(av_frame_get_buffer(frame.get(), 0), "frame");
        for (std::size_t i = 0; i < num; ++i) {
            const float value = samples[at + i];
            if (audio_codec_->sample_fmt == AV_SAMPLE_FMT_S16)
                reinterpret_cast<std::int16_t*>(frame->data[0])[i] =
                    static_cast<std::int16_t>(32767.0F * value);
            else
                reinterpret_cast<float*>(frame->data[0])[i] = value;
        }
        encode(*audio_codec_, *audio_stream_, frame.get());
    }
}

void VideoWriter::add_gpmf(const std::string& payload,
                           std::int64_t stamp_ms,
                           std::int64_t duration_ms) {
    const PacketHandle packet = new_packet();
    checked(av_new_packet(packet.get(), static_cast<int>(payload.size())), "packet");
    std::memcpy(packet->data, payload.data(), payload.size());
    packet->stream_index = gpmf_stream_->index;
    packet->pts = stamp_ms;
    packet->dts = stamp_ms;
    packet->duration = duration_ms;
    packet->flags |= AV_PKT_FLAG_KEY;
    av_packet_rescale_ts(packet.get(), {1, 1000}, gpmf_stream_->time_base);
    checked(av_interleaved_write_frame(format_, packet.get()), "write");
}

void VideoWriter::finish() {
    encode(*video_codec_, *video_stream_, nullptr);
    if (audio_codec_) encode(*audio_codec_, *audio_stream_, nullptr);
    checked(av_write_trailer(format_), "trailer");
    avio_closep(&format_->pb);
}

}  // namespace divemesh::video
