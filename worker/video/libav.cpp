#include "worker/video/libav.hpp"

#include <mutex>
#include <new>

#include "schemas/error.hpp"
#include "worker/dive/dive.hpp"

namespace divemesh::video {
namespace {

// An image of 64 megapixels with 10 bits and full colour fits.
constexpr std::size_t kMaxAllocation_bytes = std::size_t{512} << 20U;

template <typename Handle>
Handle owned(typename Handle::pointer allocated) {
    if (allocated == nullptr) throw std::bad_alloc();
    return Handle(allocated);
}

[[noreturn]] void fail(const std::string& codec, const std::string& why) {
    throw Error(ErrorCode::BadData,
                "the codec " + codec + " cannot be read: " + why +
                    ": export the video as H.264 with the camera's own program");
}

void check(int code, const AVCodecContext& codec) {
    if (code < 0) fail(avcodec_get_name(codec.codec_id), libav_text(code));
}

CodecHandle new_decoder(AVCodecID id, int num_threads) {
    const AVCodec* decoder = avcodec_find_decoder(id);
    if (decoder == nullptr) fail(avcodec_get_name(id), "libavcodec has no decoder");
    auto codec = owned<CodecHandle>(avcodec_alloc_context3(decoder));
    codec->max_pixels = dive::DiveLimits{}.max_image_pixels;
    codec->thread_count = num_threads;
    return codec;
}

}  // namespace

PacketHandle new_packet() { return owned<PacketHandle>(av_packet_alloc()); }

FrameHandle new_frame() { return owned<FrameHandle>(av_frame_alloc()); }

std::string libav_text(int code) {
    char text[AV_ERROR_MAX_STRING_SIZE] = {};
    av_strerror(code, text, sizeof text);
    return text;
}

void prepare_libav() {
    static std::once_flag once;
    std::call_once(once, [] {
        av_log_set_level(AV_LOG_QUIET);
        av_max_alloc(kMaxAllocation_bytes);
    });
}

CodecHandle open_decoder(const AVStream& stream, int num_threads) {
    auto codec = new_decoder(stream.codecpar->codec_id, num_threads);
    codec->pkt_timebase = stream.time_base;
    check(avcodec_parameters_to_context(codec.get(), stream.codecpar), *codec);
    check(avcodec_open2(codec.get(), nullptr, nullptr), *codec);
    return codec;
}

CodecHandle open_decoder(AVCodecID id, int num_threads) {
    prepare_libav();
    auto codec = new_decoder(id, num_threads);
    codec->pkt_timebase = {1, 1'000'000'000};
    check(avcodec_open2(codec.get(), nullptr, nullptr), *codec);
    return codec;
}

}  // namespace divemesh::video
