#include "worker/video/indexed_video.hpp"

#include <algorithm>
#include <utility>

#include "worker/base/seconds.hpp"

namespace divemesh::video {
namespace {

// Returns when a video ends: as it states, if that is after its last frame.
std::int64_t end_ns(const VideoIndex& index) {
    const std::int64_t last_ns = index.stamps_ns.back();
    const double stated_s = std::min(index.traits.duration_s, base::to_s(kMaxStamp_ns));
    return base::to_ns(stated_s) > last_ns ? base::to_ns(stated_s)
                                           : last_ns + base::to_ns(index.period_s());
}

}  // namespace

IndexedVideo one_file(const std::filesystem::path& path, VideoIndex index) {
    const std::int64_t first_ns = index.stamps_ns.front();
    return {{{path, 0, first_ns}}, std::move(index)};
}

bool continues(const IndexedVideo& video, const VideoIndex& chapter) {
    const VideoTraits& before = video.index.traits;
    return before.codec == chapter.traits.codec && before.width_px == chapter.traits.width_px &&
           before.height_px == chapter.traits.height_px &&
           before.rotation_deg == chapter.traits.rotation_deg;
}

void append_chapter(IndexedVideo& video, const std::filesystem::path& path, VideoIndex chapter) {
    VideoIndex& whole = video.index;
    const std::int64_t offset_ns = end_ns(whole);
    const std::int64_t chapter_ns = end_ns(chapter);
    const std::int64_t last_ns = whole.stamps_ns.back();
    const std::size_t num_before = whole.stamps_ns.size();
    for (const std::int64_t stamp_ns : chapter.stamps_ns)
        if (offset_ns + stamp_ns > last_ns) whole.stamps_ns.push_back(offset_ns + stamp_ns);
    for (GpmfPayload& payload : chapter.gpmf) {
        payload.stamp_ns += offset_ns;
        whole.gpmf.push_back(std::move(payload));
    }
    check_size(whole, path);
    if (whole.stamps_ns.size() > num_before)
        video.parts.push_back({path, offset_ns, whole.stamps_ns[num_before]});
    whole.traits.duration_s = base::to_s(offset_ns + chapter_ns);
    whole.traits.has_audio |= chapter.traits.has_audio;
    whole.traits.has_gpmf |= chapter.traits.has_gpmf;
    whole.num_repeated += chapter.num_repeated;
    whole.num_unstamped += chapter.num_unstamped;
    whole.is_cut |= chapter.is_cut;
}

}  // namespace divemesh::video
