#include "worker/video/video_reader.hpp"

#include <utility>

#include "schemas/error.hpp"
#include "worker/dive/image.hpp"

namespace divemesh::video {
namespace {

constexpr int kThreads = 0;                      // as many as the machine has cores
constexpr std::int64_t kMaxDamaged = 1'000'000;  // frames; a decoder never fails for ever

bool is_intra_only(AVCodecID codec) {
    const AVCodecDescriptor* descriptor = avcodec_descriptor_get(codec);
    return descriptor != nullptr && (descriptor->props & AV_CODEC_PROP_INTRA_ONLY) != 0;
}

// Returns a whole JPEG file without what follows it; empty if it is none, such as half an
// interlaced frame, or one that leaves its Huffman tables to the decoder.
std::string_view jpeg_file(std::string_view bytes) {
    const std::size_t end = bytes.rfind("\xFF\xD9");
    if (!bytes.starts_with("\xFF\xD8") || end == std::string_view::npos) return {};
    const std::string_view file = bytes.substr(0, end + 2);
    const std::size_t scan = file.find("\xFF\xDA");
    if (file.substr(0, scan).find("\xFF\xC4") == std::string_view::npos) return {};
    return file;
}

}  // namespace

VideoReader::VideoReader(const std::filesystem::path& path,
                         const std::vector<std::int64_t>& stamps_ns,
                         StoredJpeg stored_jpeg)
    : file_(path),
      stored_jpeg_(stored_jpeg),
      chosen_(stamps_ns.begin(), stamps_ns.end()),
      codec_(open_decoder(*file_.video(), kThreads)),
      packet_(new_packet()),
      frame_(new_frame()) {
    file_.read_only({file_.video()});
}

std::optional<VideoFrame> VideoReader::next() {
    while (!chosen_.empty()) {
        if (auto frame = decoded()) return frame;
        if (is_drained_) return std::nullopt;
        if (feed() == Fed::End) avcodec_send_packet(codec_.get(), nullptr);
        if (stored_) return std::exchange(stored_, std::nullopt);
    }
    return std::nullopt;
}

std::optional<VideoFrame> VideoReader::at(std::int64_t stamp_ns) {
    while (!ahead_ || ahead_->stamp_ns < stamp_ns)
        if (!(ahead_ = next())) return std::nullopt;
    if (ahead_->stamp_ns != stamp_ns) return std::nullopt;
    return std::exchange(ahead_, std::nullopt);
}

// Returns the next chosen frame that the decoder has ready.
std::optional<VideoFrame> VideoReader::decoded() {
    while (true) {
        const int code = avcodec_receive_frame(codec_.get(), frame_.get());
        is_drained_ = code == AVERROR_EOF || num_damaged_ > kMaxDamaged;
        if (code == AVERROR(EAGAIN) || is_drained_) return std::nullopt;
        if (code < 0) ++num_damaged_;
        if (code < 0) continue;
        const auto stamp = stamp_ns(frame_->best_effort_timestamp, *file_.video());
        if (!stamp || chosen_.erase(*stamp) == 0) continue;
        // Skips a frame of which the decoder made up a part, as the file cut its packet off.
        if ((frame_->flags & AV_FRAME_FLAG_CORRUPT) != 0) continue;
        if (frame_->width != traits().width_px || frame_->height != traits().height_px) continue;
        cv::Mat pixels = converter_.convert(*frame_, traits().rotation_deg);
        if (!pixels.empty()) return VideoFrame{*stamp, pixels, {}};
    }
}

// Gives the decoder the next packet that a chosen frame needs.
VideoReader::Fed VideoReader::feed() {
    while (file_.next(*packet_)) {
        if (packet_->stream_index != file_.video()->index) continue;
        const auto stamp = stamp_ns(*packet_, *file_.video());
        const bool is_shown = stamp && is_chosen(*stamp);
        if (!is_shown && is_intra_only(codec_->codec_id)) continue;
        if (is_shown && (stored_ = stored_frame(*packet_))) {
            chosen_.erase(*stamp);
            return Fed::Packet;
        }
        codec_->skip_frame = is_shown ? AVDISCARD_DEFAULT : AVDISCARD_NONREF;
        avcodec_send_packet(codec_.get(), packet_.get());  // what it refuses is damaged
        return Fed::Packet;
    }
    return Fed::End;
}

// Returns the frame of a packet that is a JPEG as it is to be shown.
std::optional<VideoFrame> VideoReader::stored_frame(const AVPacket& packet) const {
    if (stored_jpeg_ == StoredJpeg::Decoded || codec_->codec_id != AV_CODEC_ID_MJPEG ||
        traits().rotation_deg != 0)
        return std::nullopt;
    const auto file = jpeg_file(
        {reinterpret_cast<const char*>(packet.data), static_cast<std::size_t>(packet.size)});
    if (file.empty()) return std::nullopt;
    try {
        const dive::ImageHeader header = dive::read_image_header(file);
        if (header.width_px != traits().width_px || header.height_px != traits().height_px)
            return std::nullopt;
    } catch (const Error&) {
        return std::nullopt;
    }
    return VideoFrame{stamp_ns(packet, *file_.video()).value(), {}, std::string(file)};
}

}  // namespace divemesh::video
