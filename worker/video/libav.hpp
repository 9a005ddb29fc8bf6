#pragma once

#include <memory>
#include <string>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/avutil.h>
#include <libswscale/swscale.h>
}

// What the libraries of FFmpeg allocate, owned.
namespace divemesh::video {

struct FormatCloser {
    void operator()(AVFormatContext* format) const { avformat_close_input(&format); }
};
struct CodecFreer {
    void operator()(AVCodecContext* codec) const { avcodec_free_context(&codec); }
};
struct PacketFreer {
    void operator()(AVPacket* packet) const { av_packet_free(&packet); }
};
struct FrameFreer {
    void operator()(AVFrame* frame) const { av_frame_free(&frame); }
};
struct ScalerFreer {
    void operator()(SwsContext* scaler) const { sws_freeContext(scaler); }
};

using FormatHandle = std::unique_ptr<AVFormatContext, FormatCloser>;
using CodecHandle = std::unique_ptr<AVCodecContext, CodecFreer>;
using PacketHandle = std::unique_ptr<AVPacket, PacketFreer>;
using FrameHandle = std::unique_ptr<AVFrame, FrameFreer>;
using ScalerHandle = std::unique_ptr<SwsContext, ScalerFreer>;

// Both throw std::bad_alloc.
PacketHandle new_packet();
FrameHandle new_frame();

// Returns what FFmpeg says of a negative code.
std::string libav_text(int code);

// Silences the libraries, and limits what one allocation of theirs may take, once in a process.
void prepare_libav();

// Opens the decoder of a stream. Throws Error{BadData} if there is none, or it refuses the stream.
CodecHandle open_decoder(const AVStream& stream, int num_threads);
// Opens the decoder of a stream that is in no file, whose times are nanoseconds. Throws the same.
CodecHandle open_decoder(AVCodecID codec, int num_threads);

}  // namespace divemesh::video
