#include "worker/video/access_unit_decoder.hpp"

#include <cstring>
#include <string>

#include "schemas/error.hpp"

namespace divemesh::video {
namespace {

// Of threads a decoder holds back as many frames, each as large as the stream states.
constexpr int kThreads = 1;
// A unit of an image of 64 megapixels is smaller, and the decoder copies it.
constexpr std::size_t kMaxUnit_bytes = std::size_t{64} << 20U;
constexpr int kMaxFramesAUnit = 64;  // no stream of H.264 or H.265 holds back more

[[noreturn]] void fail(const std::string& why) { throw Error(ErrorCode::BadData, why); }

AVCodecID codec_of(std::string_view name) {
    if (name == "h264") return AV_CODEC_ID_H264;
    if (name == "h265" || name == "hevc") return AV_CODEC_ID_HEVC;
    fail("it is video in '" + std::string(name.substr(0, 20)) +
         "', and of video in messages H.264 and H.265 are read");
}

}  // namespace

std::vector<VideoFrame> AccessUnitDecoder::decode(std::string_view codec,
                                                  std::int64_t stamp_ns,
                                                  std::string_view unit) {
    const AVCodecID id = codec_of(codec);
    if (!codec_) codec_ = open_decoder(id, kThreads);
    if (codec_->codec_id != id) fail("its video changes from H.264 to H.265 or back");
    if (unit.empty() || unit.size() > kMaxUnit_bytes)
        fail("its frame has " + std::to_string(unit.size()) + " bytes");
    const PacketHandle packet = new_packet();
    if (av_new_packet(packet.get(), static_cast<int>(unit.size())) < 0)
        throw Error(ErrorCode::OutOfMemory, "no memory for a frame of video");
    std::memcpy(packet->data, unit.data(), unit.size());
    packet->pts = stamp_ns;
    ++num_units_;
    avcodec_send_packet(codec_.get(), packet.get());  // what it refuses gives no frame
    return receive();
}

std::vector<VideoFrame> AccessUnitDecoder::finish() {
    if (!codec_) return {};
    avcodec_send_packet(codec_.get(), nullptr);
    return receive();
}

std::vector<VideoFrame> AccessUnitDecoder::receive() {
    std::vector<VideoFrame> frames;
    const FrameHandle frame = new_frame();
    for (int i = 0; i < kMaxFramesAUnit; ++i) {
        const int code = avcodec_receive_frame(codec_.get(), frame.get());
        if (code == AVERROR(EAGAIN) || code == AVERROR_EOF) break;
        if (code < 0 || frame->pts == AV_NOPTS_VALUE) continue;
        if ((frame->flags & AV_FRAME_FLAG_CORRUPT) != 0 || frame->decode_error_flags != 0) continue;
        cv::Mat pixels = converter_.convert(*frame, 0);
        if (pixels.empty()) continue;
        frames.push_back({frame->pts, pixels, {}});
        ++num_frames_;
    }
    return frames;
}

}  // namespace divemesh::video
