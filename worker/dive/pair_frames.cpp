#include "worker/dive/pair_frames.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "worker/base/parallel.hpp"
#include "worker/base/seconds.hpp"
#include "worker/dive/motion_profile.hpp"
#include "worker/dive/stamp_check.hpp"
#include "worker/stats/median.hpp"
#include "worker/stats/robust.hpp"

namespace divemesh::dive {
namespace {

constexpr int kNumMoments = 12;
constexpr int kMomentsAtOnce = 2;                      // each holds three images and their pyramids
constexpr std::int64_t kMinInterval_ns = 90'000'000;   // for a feature to move by some pixels
constexpr std::int64_t kMaxInterval_ns = 600'000'000;  // for it to be found again
constexpr double kPlausibleShare = 0.2;  // of corners that fit; pairs of other times have 0 to 0.05
constexpr double kMinShare = 0.1;        // below this the images do not confirm other clocks
constexpr double kAsGoodShare = 0.9;
constexpr double kMinShareRatio = 1.5;  // by which a new pairing has to fit better
constexpr std::size_t kMaxProfileRows = 160;
constexpr double kMaxLag_s = 20.0;
constexpr std::int64_t kProfilePeriod_ns = 90'000'000;  // rows nearer to each other are left out
constexpr double kMinDelay_s = 0.005;                   // clocks that differ by less are one clock
constexpr double kDelaySigmas = 5.0;
constexpr double kMinDrift_s = 0.006;  // over the dive
constexpr double kDriftSigmas = 6.0;
constexpr double kMinMorePairs = 1.05;   // a share of pairs that are far apart, not single ones
constexpr double kMinLossRatio = 1.001;  // less is rounding

std::int64_t half_period_ns(const std::vector<CameraRow>& rows) {
    return std::max(common_clock_tolerance_ns(rows), median_period_ns(timestamps_of(rows)) / 2);
}

// Returns the tolerance for cameras on one clock: that of cameras that fire together, or half a
// frame period if many images are further apart, as those of cameras that run free are.
std::int64_t one_clock_tolerance_ns(const CameraImages& images) {
    const std::int64_t together_ns = common_clock_tolerance_ns(images.left);
    const std::int64_t apart_ns = half_period_ns(images.left);
    const auto num_pairs = [&](std::int64_t tolerance_ns) {
        return static_cast<double>(match_pairs(images.left, images.right, {}, tolerance_ns).size());
    };
    return num_pairs(apart_ns) > kMinMorePairs * num_pairs(together_ns) ? apart_ns : together_ns;
}

// Returns every n-th row between two times, so that rows are not nearer than the profile needs.
std::vector<CameraRow> rows_between(const std::vector<CameraRow>& rows,
                                    std::int64_t begin_ns,
                                    std::int64_t end_ns) {
    std::vector<CameraRow> chosen;
    for (const CameraRow& row : rows) {
        if (row.timestamp_ns < begin_ns || row.timestamp_ns > end_ns) continue;
        if (chosen.empty() || row.timestamp_ns - chosen.back().timestamp_ns >= kProfilePeriod_ns)
            chosen.push_back(row);
    }
    return chosen;
}

// A straight line through points, by the medians of slopes and of intercepts (Theil 1950).
struct Line {
    double slope = 0.0;
    double at_zero = 0.0;
    double scatter = 0.0;  // standard deviation, from the median distance
};

Line fit_line(const std::vector<std::pair<double, double>>& points, bool is_level) {
    Line line;
    std::vector<double> slopes;
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t j = i + 1; j < points.size(); ++j)
            if (points[j].first > points[i].first)
                slopes.push_back((points[j].second - points[i].second) /
                                 (points[j].first - points[i].first));
    if (!is_level) line.slope = stats::median(std::move(slopes));
    std::vector<double> intercepts;
    intercepts.reserve(points.size());
    for (const auto& [x, y] : points) intercepts.push_back(y - line.slope * x);
    line.at_zero = stats::median(intercepts);
    for (double& value : intercepts) value = std::abs(value - line.at_zero);
    line.scatter = stats::kSigmasPerMad * stats::median(std::move(intercepts));
    return line;
}

double share_fitting(const PairedFrames& frames) {
    return frames.delay.share_fitting.value_or(0.0);
}

bool same_images(const PairedFrames& a, const PairedFrames& b) {
    return std::equal(a.pairs.begin(),
                      a.pairs.end(),
                      b.pairs.begin(),
                      b.pairs.end(),
                      [](const FramePair& pair, const FramePair& other) {
                          return pair.left == other.left && pair.right == other.right;
                      });
}

// Returns what the images tell about gaps, by how well they fit without and with them.
PairGaps judge_gaps(double loss_without_px2, double loss_with_px2) {
    if (loss_with_px2 > kMinLossRatio * loss_without_px2) return PairGaps::Contradicted;
    return loss_without_px2 > kMinLossRatio * loss_with_px2 ? PairGaps::Confirmed
                                                            : PairGaps::Stated;
}

class PairFinder {
public:
    PairFinder(const CameraImages& images, const types::Rig& rig)
        : images_(images),
          rig_(rig),
          is_common_(agree_in_time(images.left, images.right)),
          one_clock_tolerance_ns_(one_clock_tolerance_ns(images)) {}

    PairedFrames find() {
        const ClockDifference guess = guess_clock_difference(images_.left, images_.right);
        PairedFrames best = pair_with(guess);
        if (!is_common_ || share_fitting(best) < kPlausibleShare) best = search(std::move(best));
        return refine(std::move(best));
    }

    bool timestamps_agree() const { return is_common_; }
    PairedFrames pair_by_timestamps() { return pair_with({}); }

private:
    PairedFrames pair_with(const ClockDifference& clocks) {
        PairedFrames frames;
        frames.clocks = clocks;
        const std::int64_t tolerance_ns =
            clocks.is_zero() && is_common_ ? one_clock_tolerance_ns_ : half_period_ns(images_.left);
        frames.pairs = match_pairs(images_.left, images_.right, clocks, tolerance_ns);
        measure(frames);
        return frames;
    }

    // Measures the delay at moments spread over the dive. Where the next pair is too late for
    // features to be found again, a moment tells only whether its pair fits.
    void measure(PairedFrames& frames) const {
        const std::vector<FramePair>& pairs = frames.pairs;
        if (pairs.empty()) return;
        std::vector<int>& moments = frames.moments;
        const int num_pairs = static_cast<int>(pairs.size());
        for (int k = 0; k < kNumMoments; ++k) {
            const int first = (2 * k + 1) * num_pairs / (2 * kNumMoments);
            if (moments.empty() || moments.back() != first) moments.push_back(first);
        }
        std::vector<EpipolarMoment> samples(moments.size());
        base::for_each_index(kMomentsAtOnce, samples.size(), [&](std::size_t k) {
            samples[k] = sample(pairs, moments[k], next_after(pairs, moments[k]));
        });
        frames.delay = estimate_delay(samples);
        if (frames.gaps_vary()) measure_beyond_gaps(std::move(samples), frames);
    }

    // Replaces the delay by that beyond each pair's gap, unless one delay for all pairs fits the
    // images better. Images that show too little to tell leave it to the timestamps.
    static void measure_beyond_gaps(std::vector<EpipolarMoment> samples, PairedFrames& frames) {
        std::vector<double> gaps_s;
        for (const int moment : frames.moments)
            gaps_s.push_back(
                base::to_s(frames.gap_ns(frames.pairs[static_cast<std::size_t>(moment)])));
        StereoDelay beyond = estimate_delay(without_gaps(std::move(samples), gaps_s));
        frames.gaps = judge_gaps(frames.delay.loss_px2, beyond.loss_px2);
        if (frames.uses_gaps()) frames.delay = std::move(beyond);
    }

    // Returns the first pair far enough after `first` for features to have moved; `first` if none.
    static int next_after(const std::vector<FramePair>& pairs, int first) {
        for (int i = first + 1; i < static_cast<int>(pairs.size()); ++i) {
            const std::int64_t interval_ns = pairs[static_cast<std::size_t>(i)].timestamp_ns -
                                             pairs[static_cast<std::size_t>(first)].timestamp_ns;
            if (interval_ns > kMaxInterval_ns) return first;
            if (interval_ns >= kMinInterval_ns) return i;
        }
        return first;
    }

    EpipolarMoment sample(const std::vector<FramePair>& pairs, int first, int later) const {
        const FramePair& a = pairs[static_cast<std::size_t>(first)];
        const FramePair& b = pairs[static_cast<std::size_t>(later)];
        const cv::Mat left = images_.load_left({a.timestamp_ns, a.left});
        const cv::Mat right = images_.load_right({a.right_ns, a.right});
        const cv::Mat after =
            later == first ? cv::Mat() : images_.load_left({b.timestamp_ns, b.left});
        if (left.empty() || right.empty()) return {};
        if (left.size() != right.size()) return {};  // refused later: calibration_resolution
        return sample_epipolar_errors(
            rig_, left, right, after, base::to_s(b.timestamp_ns - a.timestamp_ns));
    }

    // Compares how both images move over time, and pairs by the lag between them if that fits
    // clearly better.
    PairedFrames search(PairedFrames known) {
        const auto middle = images_.left.size() / 2;
        const auto begin = middle - std::min(middle, kMaxProfileRows / 2);
        const std::int64_t begin_ns = images_.left[begin].timestamp_ns;
        const std::int64_t end_ns =
            begin_ns + 2 * kProfilePeriod_ns * static_cast<std::int64_t>(kMaxProfileRows);
        auto left = rows_between(images_.left, begin_ns, end_ns);
        left.resize(std::min(left.size(), kMaxProfileRows));
        if (left.empty()) return known;
        const std::int64_t base_ns = known.clocks.at(begin_ns);
        const auto right =
            rows_between(images_.right,
                         begin_ns + base_ns - base::to_ns(kMaxLag_s),
                         left.back().timestamp_ns + base_ns + base::to_ns(kMaxLag_s));
        const auto lag =
            find_lag(motion_profile(timestamps_of(left),
                                    begin_ns,
                                    [&](std::size_t i) { return images_.load_left(left[i]); }),
                     motion_profile(timestamps_of(right),
                                    begin_ns + base_ns,
                                    [&](std::size_t i) { return images_.load_right(right[i]); }),
                     kMaxLag_s);
        if (!lag || !lag->is_clear()) return known;
        ClockDifference clocks = known.clocks;
        clocks.offset_ns += base::to_ns(lag->lag_s);
        clocks.reference_ns = begin_ns;
        PairedFrames found = pair_with(clocks);
        // At slow rates few corners are found again, however well the timestamps agree.
        if (is_common_ && same_images(found, known)) return known;
        const double share = share_fitting(known);
        // Without motion from image to image all delays are 0.
        const bool have_delays = known.delay.rate_px_s > 0.0 && found.delay.rate_px_s > 0.0;
        const bool is_as_good = have_delays && share_fitting(found) > kAsGoodShare * share &&
                                std::abs(found.delay.delay_s) <= std::abs(known.delay.delay_s);
        const bool is_better = is_as_good || share_fitting(found) > kMinShareRatio * share;
        return is_better ? found : known;
    }

    // Takes off the delay that the images show, and the drift, as far as other pairs reduce it.
    PairedFrames refine(PairedFrames known) {
        for (int i = 0; i < 3; ++i) {
            const auto clocks = clocks_by_images(known);
            if (!clocks) return known;
            PairedFrames found = pair_with(*clocks);
            const bool is_same = same_images(found, known);
            const bool is_better = std::abs(found.delay.delay_s) < std::abs(known.delay.delay_s) ||
                                   share_fitting(found) > share_fitting(known);
            if (!is_same && !is_better) return known;
            known = std::move(found);
            // Other clocks change what is measured of the same images only where it is beyond gaps.
            if (is_same && !known.uses_gaps()) return known;
        }
        return known;
    }

    // Returns the difference of the clocks that the images show; nullopt if they agree with what is
    // known.
    std::optional<ClockDifference> clocks_by_images(const PairedFrames& known) const {
        std::vector<std::pair<double, double>> points;  // time, difference of the clocks; s
        const std::int64_t start_ns = images_.left.front().timestamp_ns;
        for (std::size_t k = 0; k < known.delay.by_moment_s.size(); ++k) {
            const FramePair& pair = known.pairs[static_cast<std::size_t>(known.moments[k])];
            const double delay_s = known.delay.by_moment_s[k];
            if (!std::isfinite(delay_s)) continue;
            // Where the gap is used, the delay is already that beyond it.
            const double gap_s = known.uses_gaps() ? 0.0 : base::to_s(known.gap_ns(pair));
            points.emplace_back(base::to_s(pair.timestamp_ns - start_ns), gap_s - delay_s);
        }
        if (!known.delay.is_determined) return std::nullopt;
        const Line level = fit_line(points, true);
        const Line line = fit_line(points, false);
        const double span_s = points.back().first - points.front().first;
        const bool drifts =
            std::abs(line.slope) * span_s > std::max(kMinDrift_s, kDriftSigmas * line.scatter) &&
            line.scatter < 0.5 * level.scatter;
        if (!drifts && !known.delay.is_significant()) return std::nullopt;
        const Line& best = drifts ? line : level;
        const double unsure_s = std::max(kMinDelay_s, kDelaySigmas * known.delay.sigma_s);
        if (!drifts && std::abs(base::to_s(known.clocks.at(start_ns)) + best.at_zero) < unsure_s)
            return ClockDifference{};  // the timestamps are right, and the cameras are not together
        ClockDifference clocks = known.clocks;
        clocks.offset_ns = known.clocks.at(start_ns) + base::to_ns(best.at_zero);
        clocks.reference_ns = start_ns;
        clocks.drift += best.slope;
        return clocks;
    }

    const CameraImages& images_;
    const types::Rig& rig_;
    bool is_common_;  // most images have a partner by timestamps alone
    std::int64_t one_clock_tolerance_ns_;
};

}  // namespace

PairedFrames pair_frames(const CameraImages& images, const types::Rig& rig) {
    if (images.left.empty() || images.right.empty()) return {};
    PairFinder finder(images, rig);
    PairedFrames frames = finder.find();
    const auto share = frames.delay.share_fitting;
    const bool is_confirmed = frames.clocks.is_zero() || !share || *share >= kMinShare;
    if (is_confirmed) return frames;
    // Open water shows a chance lag, which is no reason to doubt timestamps that agree.
    if (finder.timestamps_agree()) return finder.pair_by_timestamps();
    frames.pairs.clear();
    return frames;
}

}  // namespace divemesh::dive
