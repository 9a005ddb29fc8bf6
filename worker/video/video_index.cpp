#include "worker/video/video_index.hpp"

#include <algorithm>

#include "schemas/error.hpp"
#include "worker/base/seconds.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::video {
namespace {

constexpr std::size_t kMaxFrames = 20'000'000;                      // a week at 30 a second
constexpr std::size_t kMaxTelemetry_bytes = std::size_t{1} << 28U;  // a GoPro writes 20 MB an hour
constexpr std::size_t kReportEvery = 256;                           // packets
constexpr double kCut_s = 1.0;  // streams of a whole file end this near each other

[[noreturn]] void fail_too_large(const std::filesystem::path& path) {
    throw Error(ErrorCode::TooLarge,
                path.string() + " holds more frames or telemetry than are read: cut it into parts");
}

std::size_t size_of(const GpmfPayload& payload) {
    return payload.bytes.size() + sizeof(GpmfPayload);
}

void sort_stamps(VideoIndex& index) {
    auto& stamps = index.stamps_ns;
    std::sort(stamps.begin(), stamps.end());
    const auto end = std::unique(stamps.begin(), stamps.end());
    index.num_repeated = std::distance(end, stamps.end());
    stamps.erase(end, stamps.end());
}

double part_read(const VideoIndex& index) {
    if (index.stamps_ns.empty() || !(index.traits.duration_s > 0.0)) return 0.0;
    return std::clamp(base::to_s(index.stamps_ns.back()) / index.traits.duration_s, 0.0, 1.0);
}

// Takes the stamp of a frame, or a payload of telemetry.
void take(const AVPacket& packet, const VideoFile& file, VideoIndex& index) {
    if (packet.stream_index == file.video()->index) {
        if ((packet.flags & AV_PKT_FLAG_DISCARD) != 0) return;  // cut away by an edit list
        const auto stamp = stamp_ns(packet, *file.video());
        if (stamp)
            index.stamps_ns.push_back(*stamp);
        else
            ++index.num_unstamped;
    } else if (file.gpmf() != nullptr && packet.stream_index == file.gpmf()->index) {
        const auto stamp = stamp_ns(packet, *file.gpmf());
        const auto duration = stamp_ns(packet.duration, *file.gpmf());
        if (!stamp) return;
        index.gpmf.push_back({*stamp,
                              std::max<std::int64_t>(duration.value_or(0), 0),
                              {reinterpret_cast<const char*>(packet.data),
                               static_cast<std::size_t>(std::max(packet.size, 0))}});
    }
}

}  // namespace

double VideoIndex::period_s() const {
    std::vector<std::int64_t> periods_ns;
    for (std::size_t i = 1; i < stamps_ns.size(); ++i)
        periods_ns.push_back(stamps_ns[i] - stamps_ns[i - 1]);
    return periods_ns.empty() ? 0.0 : base::to_s(stats::upper_median(std::move(periods_ns)));
}

VideoIndex read_index(const std::filesystem::path& path, const base::ProgressCallback& progress) {
    VideoFile file(path);
    file.read_only({file.video(), file.gpmf()});
    VideoIndex index;
    index.traits = file.traits();
    const PacketHandle packet = new_packet();
    std::size_t num_packets = 0;
    std::size_t telemetry_bytes = 0;
    while (file.next(*packet)) {
        if (num_packets++ % kReportEvery == 0) progress({"index", part_read(index)});
        const std::size_t before = index.gpmf.size();
        take(*packet, file, index);
        if (index.gpmf.size() > before) telemetry_bytes += size_of(index.gpmf.back());
        if (num_packets > kMaxFrames || telemetry_bytes > kMaxTelemetry_bytes) fail_too_large(path);
    }
    sort_stamps(index);
    if (index.stamps_ns.empty())
        throw Error(ErrorCode::BadData,
                    path.string() + " holds no frame that can be read: copy it again");
    const double end_s = base::to_s(index.stamps_ns.back());
    index.is_cut = file.is_broken() || end_s + index.period_s() + kCut_s < index.traits.duration_s;
    return index;
}

void check_size(const VideoIndex& index, const std::filesystem::path& path) {
    std::size_t telemetry_bytes = 0;
    for (const GpmfPayload& payload : index.gpmf) telemetry_bytes += size_of(payload);
    if (index.stamps_ns.size() > kMaxFrames || telemetry_bytes > kMaxTelemetry_bytes)
        fail_too_large(path);
}

}  // namespace divemesh::video
