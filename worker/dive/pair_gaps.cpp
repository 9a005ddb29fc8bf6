#include <algorithm>
#include <cstdlib>

#include "worker/base/seconds.hpp"
#include "worker/dive/pair_frames.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::dive {
namespace {

// Gaps that differ from the median by less are the same. A drift is not known better by the images.
constexpr double kMinChange_s = 0.001;
constexpr double kMinChangeOfDrift_s = 0.003;

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
    return std::ranges::any_of(
        gaps_ns, [&](std::int64_t gap_ns) { return std::abs(gap_ns - median_ns) > min_ns; });
}

double PairedFrames::right_delay_s(const FramePair& pair) const {
    const double shared_s = delay.is_significant() ? delay.delay_s : 0.0;
    return uses_gaps() ? base::to_s(gap_ns(pair)) + shared_s : shared_s;
}

void use_right_clock(PairedFrames& frames) {
    for (FramePair& pair : frames.pairs) pair.timestamp_ns += frames.clocks.at(pair.timestamp_ns);
    frames.has_right_clock = true;
}

}  // namespace divemesh::dive
