#include "worker/video/video_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <unistd.h>
#include <utility>

#include "schemas/error.hpp"
#include "worker/dive/dive.hpp"

extern "C" {
#include <libavutil/display.h>
#include <libavutil/mathematics.h>
#include <libavutil/parseutils.h>
#include <libavutil/timecode.h>
}

namespace divemesh::video {
namespace {

constexpr int kMaxStreams = 64;  // a GoPro writes five
// FFmpeg's readers of MP4 and MOV, MKV and AVI: no playlist, which would name other files.
constexpr const char* kFormats = "mov,mp4,m4a,3gp,3g2,mj2,matroska,webm,avi";
constexpr std::uint32_t kGpmfTag = MKTAG('g', 'p', 'm', 'd');
constexpr std::int64_t kFirstCreation_ns = 978'307'200'000'000'000;   // 2001: before, it is unset
constexpr std::int64_t kLastCreation_ns = 3'786'912'000'000'000'000;  // 2090
constexpr double kRightAngles_deg = 1.0;  // a rotation this near a right angle is one

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& what) {
    throw Error(ErrorCode::BadData, path.string() + ": " + what);
}

[[noreturn]] void fail_to_open(const std::filesystem::path& path, int code) {
    const std::string what = "cannot read " + path.string() + ": " + libav_text(code) +
                             ": check the path and the right to read it";
    if (code == AVERROR(ENOENT)) throw Error(ErrorCode::NotFound, what);
    if (code == AVERROR(EACCES) || code == AVERROR(EIO) || code == AVERROR(EISDIR))
        throw Error(ErrorCode::Unavailable, what);
    fail(path,
         "it is no MP4, MOV, MKV or AVI that can be read (" + libav_text(code) +
             "): copy it again; a camera that lost power writes no index: let the camera repair "
             "its card, or use a program that restores MP4 files");
}

FormatHandle open_format(const std::filesystem::path& path) {
    prepare_libav();
    AVFormatContext* format = avformat_alloc_context();
    if (format == nullptr) throw std::bad_alloc();
    format->max_streams = kMaxStreams;
    AVDictionary* options = nullptr;
    av_dict_set(&options, "format_whitelist", kFormats, 0);
    av_dict_set(&options, "protocol_whitelist", "file", 0);
    // The prefix keeps a name with a colon from being an address.
    const int code =
        avformat_open_input(&format, ("file:" + path.string()).c_str(), nullptr, &options);
    av_dict_free(&options);
    if (code < 0) fail_to_open(path, code);  // which has freed `format`
    FormatHandle opened(format);
    const int found = avformat_find_stream_info(format, nullptr);
    if (found < 0) fail_to_open(path, found);
    return opened;
}

const char* entry(const AVDictionary* metadata, const char* key) {
    const AVDictionaryEntry* found = av_dict_get(metadata, key, nullptr, 0);
    return found == nullptr ? nullptr : found->value;
}

// Returns how a matrix for display turns the image, clockwise.
int rotation_of(const AVStream& stream, const std::filesystem::path& path) {
    const auto* data = av_stream_get_side_data(&stream, AV_PKT_DATA_DISPLAYMATRIX, nullptr);
    if (data == nullptr) return 0;
    const auto* matrix = reinterpret_cast<const std::int32_t*>(data);
    const double angle_deg = -av_display_rotation_get(matrix);
    const double determinant =
        static_cast<double>(matrix[0]) * matrix[4] - static_cast<double>(matrix[1]) * matrix[3];
    const double nearest_deg = 90.0 * std::round(angle_deg / 90.0);
    if (!(std::abs(angle_deg - nearest_deg) <= kRightAngles_deg) || determinant <= 0.0)
        fail(path,
             "it is to be shown mirrored or turned by other than a right angle, which no "
             "calibration describes: export it without that");
    return (static_cast<int>(nearest_deg) % 360 + 360) % 360;
}

std::optional<double> timecode_of(const char* text, AVRational rate) {
    AVTimecode timecode;
    if (text == nullptr || rate.num <= 0 || rate.den <= 0 ||
        av_timecode_init_from_string(&timecode, rate, text, nullptr) < 0)
        return std::nullopt;
    return timecode.start / av_q2d(rate);
}

}  // namespace

bool is_video(std::string_view head) {
    if (head.starts_with("\x1A\x45\xDF\xA3")) return true;  // EBML
    if (head.starts_with("RIFF"))
        return head.substr(std::min<std::size_t>(8, head.size()), 4) == "AVI ";
    const auto box = head.substr(std::min<std::size_t>(4, head.size()), 4);
    return box == "ftyp" || box == "moov" || box == "mdat" || box == "wide" || box == "free" ||
           box == "skip";
}

VideoFile::VideoFile(std::filesystem::path path)
    : path_(std::move(path)), format_(open_format(path_)) {
    find_streams();
    read_traits();
    read_clocks();
}

void VideoFile::find_streams() {
    const int best = av_find_best_stream(format_.get(), AVMEDIA_TYPE_VIDEO, -1, -1, nullptr, 0);
    if (best < 0) fail(path_, "it holds no video: give the file that has the images");
    video_ = format_->streams[best];
    const int audio = av_find_best_stream(format_.get(), AVMEDIA_TYPE_AUDIO, -1, best, nullptr, 0);
    if (audio >= 0) audio_ = format_->streams[audio];
    for (unsigned i = 0; i < format_->nb_streams; ++i)
        if (format_->streams[i]->codecpar->codec_tag == kGpmfTag && gpmf_ == nullptr)
            gpmf_ = format_->streams[i];
}

void VideoFile::read_traits() {
    const AVCodecParameters& coded = *video_->codecpar;
    traits_.codec = avcodec_get_name(coded.codec_id);
    traits_.width_px = coded.width;
    traits_.height_px = coded.height;
    if (coded.width <= 0 || coded.height <= 0 ||
        traits_.width_px * traits_.height_px > dive::DiveLimits{}.max_image_pixels)
        fail(path_,
             "it states images of " + std::to_string(coded.width) + " x " +
                 std::to_string(coded.height) + " px; up to 64 megapixels are read");
    traits_.rotation_deg = rotation_of(*video_, path_);
    traits_.is_interlaced =
        coded.field_order != AV_FIELD_PROGRESSIVE && coded.field_order != AV_FIELD_UNKNOWN;
    if (video_->avg_frame_rate.den > 0) traits_.rate_hz = av_q2d(video_->avg_frame_rate);
    if (video_->duration > 0)
        traits_.duration_s = static_cast<double>(video_->duration) * av_q2d(video_->time_base);
    else if (format_->duration > 0)
        traits_.duration_s = static_cast<double>(format_->duration) / AV_TIME_BASE;
    traits_.has_audio = audio_ != nullptr;
    traits_.has_gpmf = gpmf_ != nullptr;
}

void VideoFile::read_clocks() {
    const char* creation = entry(format_->metadata, "creation_time");
    std::int64_t creation_us = 0;
    if (creation != nullptr && av_parse_time(&creation_us, creation, 0) >= 0 &&
        creation_us > kFirstCreation_ns / 1000 && creation_us < kLastCreation_ns / 1000) {
        traits_.creation_ns = creation_us * 1000;
        // MP4 counts whole seconds.
        traits_.has_fine_creation = creation_us % 1'000'000 != 0;
    }
    traits_.timecode_s = timecode_of(entry(format_->metadata, "timecode"), video_->avg_frame_rate);
    for (unsigned i = 0; i < format_->nb_streams && !traits_.timecode_s; ++i)
        traits_.timecode_s =
            timecode_of(entry(format_->streams[i]->metadata, "timecode"), video_->avg_frame_rate);
}

void VideoFile::read_only(std::initializer_list<const AVStream*> streams) {
    for (unsigned i = 0; i < format_->nb_streams; ++i) {
        AVStream* stream = format_->streams[i];
        const bool is_read = std::find(streams.begin(), streams.end(), stream) != streams.end();
        stream->discard = is_read ? AVDISCARD_NONE : AVDISCARD_ALL;
    }
}

bool VideoFile::next(AVPacket& packet) {
    av_packet_unref(&packet);
    const int code = av_read_frame(format_.get(), &packet);
    if (code >= 0) return true;
    is_broken_ = code != AVERROR_EOF || (format_->pb != nullptr && format_->pb->error < 0);
    return false;
}

std::optional<std::int64_t> stamp_ns(std::int64_t ticks, const AVStream& stream) {
    if (ticks == AV_NOPTS_VALUE || stream.time_base.num <= 0 || stream.time_base.den <= 0)
        return std::nullopt;
    const std::int64_t ns = av_rescale_q(ticks, stream.time_base, {1, 1'000'000'000});
    if (ns < -kMaxStamp_ns || ns > kMaxStamp_ns) return std::nullopt;
    return ns;
}

std::optional<std::int64_t> stamp_ns(const AVPacket& packet, const AVStream& stream) {
    return stamp_ns(packet.pts == AV_NOPTS_VALUE ? packet.dts : packet.pts, stream);
}

}  // namespace divemesh::video
