#include "worker/dive/paired_frames.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "worker/base/seconds.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::dive {
namespace {

// Gaps that differ from the median by less are the same. A drift is not known better by the images.
constexpr double kMinChange_s = 0.001;
constexpr double kMinChangeOfDrift_s = 0.003;
// Fewer pairs whose gap differs are outliers, often of the timestamp alone.
constexpr double kMinShareChanged = 0.02;
constexpr double kMinNumChanged = 3.0;
constexpr double kMinDelay_s = 0.0005;  // for a shorter one no image is worth warping
// Where the images show too little to measure them.
constexpr double kUsualDelaySigma_s = 0.002;
constexpr double kUsualSpeed_m_s = 0.3;

}  // namespace

std::int64_t PairedFrames::gap_ns(const FramePair& pair) const {
    const std::int64_t clocks_ns = has_right_clock ? 0 : clocks.at(pair.timestamp_ns);
    return pair.right_ns - pair.timestamp_ns - clocks_ns;
}

bool PairedFrames::gaps_vary() const {
    std::vector<std::int64_t> gaps_ns;
    gaps_ns.reserve(pairs.size());
    for (const FramePair& pair : pairs) gaps_ns.push_back(gap_ns(pair));
    const std::int64_t median_ns = stats::upper_median(gaps_ns);
    const std::int64_t min_ns =
        base::to_ns(clocks.drift == 0.0 ? kMinChange_s : kMinChangeOfDrift_s);
    const auto num_changed = static_cast<double>(std::ranges::count_if(
        gaps_ns, [&](std::int64_t gap_ns) { return std::abs(gap_ns - median_ns) > min_ns; }));
    const auto num = static_cast<double>(gaps_ns.size());
    return num_changed >= std::max(kMinNumChanged, kMinShareChanged * num);
}

double PairedFrames::right_delay_s(const FramePair& pair) const {
    const double shared_s = delay.is_significant() ? delay.delay_s : 0.0;
    if (!uses_gaps()) return shared_s;
    const double delay_s = base::to_s(gap_ns(pair)) + shared_s;
    return std::abs(delay_s) < kMinDelay_s ? 0.0 : delay_s;
}

double PairedFrames::shared_delay_sigma_m() const {
    if (!delay.is_significant() && !uses_gaps()) return 0.0;
    const double sigma_s =
        delay.is_determined ? delay.sigma_s : std::max(delay.sigma_s, kUsualDelaySigma_s);
    return sigma_s * (delay.speed_m_s > 0.0 ? delay.speed_m_s : kUsualSpeed_m_s);
}

void use_right_clock(PairedFrames& frames) {
    for (FramePair& pair : frames.pairs) pair.timestamp_ns += frames.clocks.at(pair.timestamp_ns);
    frames.has_right_clock = true;
}

}  // namespace divemesh::dive
