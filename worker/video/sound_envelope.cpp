#include "worker/video/sound_envelope.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "schemas/error.hpp"
#include "worker/base/seconds.hpp"
#include "worker/video/video_file.hpp"

namespace divemesh::video {
namespace {

constexpr int kThreads = 1;
constexpr int kMinRate_hz = 8000;  // two samples a bin
constexpr int kMaxRate_hz = 400'000;

template <typename Value>
float value_of(const AVFrame& frame, int channel, int num_channels, int at, double offset) {
    const bool is_planar = av_sample_fmt_is_planar(static_cast<AVSampleFormat>(frame.format)) != 0;
    const auto* values =
        reinterpret_cast<const Value*>(frame.extended_data[is_planar ? channel : 0]);
    const Value value = values[is_planar ? at : at * num_channels + channel];
    constexpr double kScale = std::is_floating_point_v<Value> ? 1.0 : 1u << (8 * sizeof(Value) - 1);
    return static_cast<float>((static_cast<double>(value) - offset) / kScale);
}

// Returns a channel's sample, within -1 to 1; 0 for a format that no decoder of cameras gives.
float sample_of(const AVFrame& frame, int channel, int num_channels, int at) {
    switch (av_get_packed_sample_fmt(static_cast<AVSampleFormat>(frame.format))) {
        case AV_SAMPLE_FMT_U8: return value_of<std::uint8_t>(frame, channel, num_channels, at, 128);
        case AV_SAMPLE_FMT_S16: return value_of<std::int16_t>(frame, channel, num_channels, at, 0);
        case AV_SAMPLE_FMT_S32: return value_of<std::int32_t>(frame, channel, num_channels, at, 0);
        case AV_SAMPLE_FMT_FLT: return value_of<float>(frame, channel, num_channels, at, 0);
        case AV_SAMPLE_FMT_DBL: return value_of<double>(frame, channel, num_channels, at, 0);
        default: return 0.0F;
    }
}

// Adds up decoded sound by bins.
class LoudnessBins {
public:
    explicit LoudnessBins(double max_s) : max_bins_(max_s / SoundEnvelope::kBin_s) {}

    // Returns false once the sound is as long as it may be.
    bool add(const AVFrame& frame, const AVStream& stream, std::int64_t offset_ns) {
        const auto stamp = stamp_ns(frame.best_effort_timestamp, stream);
        const int num_channels = frame.ch_layout.nb_channels;
        if (!stamp || num_channels < 1 || frame.sample_rate < kMinRate_hz ||
            frame.sample_rate > kMaxRate_hz)
            return true;
        const double stamp_s = base::to_s(*stamp + offset_ns);
        if (!start_s_) start_s_ = stamp_s;
        const double first = (stamp_s - *start_s_) / SoundEnvelope::kBin_s;
        const double step = 1.0 / (frame.sample_rate * SoundEnvelope::kBin_s);
        for (int i = 0; i < frame.nb_samples; ++i) {
            float mean = 0.0F;
            for (int channel = 0; channel < num_channels; ++channel)
                mean += sample_of(frame, channel, num_channels, i);
            mean /= static_cast<float>(num_channels);
            const double bin = first + step * i;
            if (bin >= max_bins_) return false;
            if (bin >= 0.0 && std::isfinite(mean)) add(static_cast<std::size_t>(bin), mean);
        }
        return true;
    }

    SoundEnvelope envelope() {
        for (float& value : loudness_) value = std::sqrt(value);
        return {start_s_.value_or(0.0), std::move(loudness_)};
    }

private:
    // Takes the difference of neighbours, which leaves out the rumble of a housing.
    void add(std::size_t bin, float value) {
        if (bin >= loudness_.size()) loudness_.resize(bin + 1);
        const float change = value - before_;
        before_ = value;
        loudness_[bin] += change * change;
    }

    double max_bins_;
    std::optional<double> start_s_;
    std::vector<float> loudness_;
    float before_ = 0.0F;
};

// Passes on all that the decoder has ready; returns false once there is enough.
bool drain(AVCodecContext& codec,
           AVFrame& frame,
           const AVStream& stream,
           std::int64_t offset_ns,
           LoudnessBins& bins) {
    while (avcodec_receive_frame(&codec, &frame) >= 0)
        if (!bins.add(frame, stream, offset_ns)) return false;
    return true;
}

// Adds the sound of a file, if it has one; returns false once there is enough.
bool add_sound(const VideoPart& part,
               double max_s,
               LoudnessBins& bins,
               const base::ProgressCallback& progress) {
    VideoFile file(part.path);
    if (file.audio() == nullptr) return true;
    file.read_only({file.audio()});
    CodecHandle codec;
    try {
        codec = open_decoder(*file.audio(), kThreads);
    } catch (const Error&) {
        return true;  // the images are what matters
    }
    const PacketHandle packet = new_packet();
    const FrameHandle frame = new_frame();
    bool is_short = true;
    while (is_short && file.next(*packet)) {
        if (packet->stream_index != file.audio()->index) continue;
        const auto stamp = stamp_ns(*packet, *file.audio());
        const double passed_s = base::to_s(stamp.value_or(0) + part.offset_ns);
        progress({"sound", std::clamp(passed_s / max_s, 0.0, 1.0)});
        avcodec_send_packet(codec.get(), packet.get());
        is_short = drain(*codec, *frame, *file.audio(), part.offset_ns, bins);
    }
    if (!is_short) return false;
    avcodec_send_packet(codec.get(), nullptr);
    return drain(*codec, *frame, *file.audio(), part.offset_ns, bins);
}

}  // namespace

SoundEnvelope read_sound(const std::vector<VideoPart>& parts,
                         double max_s,
                         const base::ProgressCallback& progress) {
    LoudnessBins bins(max_s);
    for (const VideoPart& part : parts)
        if (!add_sound(part, max_s, bins, progress)) break;
    return bins.envelope();
}

}  // namespace divemesh::video
