#include "worker/video/motion_offset.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "worker/base/part_of.hpp"
#include "worker/base/seconds.hpp"
#include "worker/dive/motion_profile.hpp"
#include "worker/video/joined_reader.hpp"
#include "worker/video/plan_pairs.hpp"

namespace divemesh::video {
namespace {

constexpr double kCompared_s = 60.0;
constexpr double kRate_hz = 30.0;
constexpr double kMaxLag_s = 40.0;
constexpr double kSigmaPeriods = 0.25;  // lags are tried in quarters of a period

std::vector<std::int64_t> compared_stamps_ns(const VideoIndex& index) {
    std::vector<std::int64_t> stamps_ns;
    const std::int64_t end_ns = index.stamps_ns.front() + base::to_ns(kCompared_s);
    for (const PlannedPair& pair : plan_pairs(index.stamps_ns, index.stamps_ns, {}, kRate_hz))
        if (pair.left_ns < end_ns) stamps_ns.push_back(pair.left_ns);
    return stamps_ns;
}

dive::MotionProfile profile_of(const IndexedVideo& video, const base::ProgressCallback& progress) {
    const auto stamps_ns = compared_stamps_ns(video.index);
    JoinedReader reader(video.parts, stamps_ns, StoredJpeg::Decoded);
    return dive::motion_profile(stamps_ns, 0, [&](std::size_t i) {
        progress({"motion", static_cast<double>(i) / static_cast<double>(stamps_ns.size())});
        const auto frame = reader.at(stamps_ns[i]);
        if (!frame || frame->pixels.channels() == 1) return frame ? frame->pixels : cv::Mat();
        cv::Mat grey;
        cv::cvtColor(frame->pixels, grey, cv::COLOR_BGR2GRAY);
        return grey;
    });
}

}  // namespace

std::optional<ClockOffset> offset_by_motion(const IndexedVideo& left,
                                            const IndexedVideo& right,
                                            const base::ProgressCallback& progress) {
    const auto left_profile = profile_of(left, base::part_of(progress, 0.0, 0.5));
    const auto right_profile = profile_of(right, base::part_of(progress, 0.5, 1.0));
    const auto lag = dive::find_lag(left_profile, right_profile, kMaxLag_s);
    if (!lag || !lag->is_clear()) return std::nullopt;
    const double period_s =
        std::max({left.index.period_s(), right.index.period_s(), 1.0 / kRate_hz});
    return ClockOffset{0.0 - lag->lag_s, 0.0, kSigmaPeriods * period_s};
}

}  // namespace divemesh::video
