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
    const AVCodecID id = stream.codecpar->codec_id;
    const std::string name = avcodec_get_name(id);
    const AVCodec* decoder = avcodec_find_decoder(id);
    if (decoder == nullptr) fail(name, "libavcodec has no decoder");
    auto codec = owned<CodecHandle>(avcodec_alloc_context3(decoder));
    int code = avcodec_parameters_to_context(codec.get(), stream.codecpar);
    codec->max_pixels = dive::DiveLimits{}.max_image_pixels;
    codec->pkt_timebase = stream.time_base;
    codec->thread_count = num_threads;
    if (code >= 0) code = avcodec_open2(codec.get(), decoder, nullptr);
    if (code < 0) fail(name, libav_text(code));
    return codec;
}

}  // namespace divemesh::video
