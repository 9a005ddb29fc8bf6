#include "worker/pipeline/align_cameras.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "schemas/error.hpp"
#include "worker/base/parallel.hpp"
#include "worker/calibration/stereo_alignment.hpp"
#include "worker/camera/rectified_lens.hpp"
#include "worker/camera/rectifier.hpp"
#include "worker/camera/synchronise_pair.hpp"
#include "worker/camera/virtual_camera.hpp"
#include "worker/features/match_misaligned_stereo.hpp"
#include "worker/pipeline/range_windows.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::pipeline {
namespace {

constexpr std::size_t kMaxPairs = 48;
constexpr std::size_t kPairsAtOnce = 12;  // also the min of a longer dive
constexpr std::size_t kMinMatches = 2000;
constexpr std::size_t kWindowsAtOnce = 6;
constexpr int kFramesPerWindow = 8;  // of the dive; more windows would read frames twice
// Windows are added until the disparity bias is known this well; the second value is for a bias
// that is not significant.
constexpr double kMaxBiasSigma_px = 0.04;
constexpr double kMaxUnbiasedSigma_px = 0.12;
// What tells how far the survey is away: matches, and their disparities.
constexpr std::size_t kMinSurveyed = 20;
constexpr double kMinSurveyed_px = 2.0;
// Refractive index of water: 1.333 in a lake, 1.342 in a cold sea.
constexpr double kWater = 1.337;
constexpr std::array<types::MediumChange, 4> kOtherMedia = {
    {{1.0, kWater}, {kWater, 1.0}, {1.0, 1.0 / kWater}, {1.0 / kWater, 1.0}}};
constexpr double kMinBias_rad = 0.003;  // of the disparities; a wrong medium: 0.0056 and more
constexpr int kMinRanges = 100;
constexpr double kMaxInliersLost = 0.02;  // share of the matches
// Shares of the errors. A right medium left 0.16 to 0.26 of both (product), a wrong one 0.55 and
// more.
constexpr double kMaxErrorRatio = 0.7;
constexpr double kMaxErrorProduct = 0.4;

// Returns i as a fraction with its binary digits reversed: any first few are spread evenly over
// [0, 1) (van der Corput 1935).
double radical_inverse(std::uint32_t i) {
    double value = 0.0;
    for (double digit = 0.5; i > 0; digit *= 0.5, i >>= 1U)
        if (i & 1U) value += digit;
    return value;
}

// Returns frames spread over the dive, also if only the first few of them are read.
std::vector<int> spread_frames(int num_frames) {
    const auto num = std::min<std::size_t>(kMaxPairs, static_cast<std::size_t>(num_frames));
    std::vector<int> frames;
    for (std::uint32_t i = 0; frames.size() < num; ++i) {
        const int frame = static_cast<int>(radical_inverse(i) * num_frames);
        if (std::ranges::find(frames, frame) == frames.end()) frames.push_back(frame);
    }
    return frames;
}

// Matches pairs after rectification with one rig and returns them as rectified with `stated`.
class PairMatcher {
public:
    PairMatcher(const types::Recording& recording,
                const types::Rig& stated,
                const types::Rig& rig,
                int num_threads)
        : recording_(recording),
          rectifier_(rig, recording.fixed_pattern(), num_threads),
          lenses_(camera::rectified_lenses(rig)),
          stated_rectified_(camera::rectified_rig(stated, recording.fixed_pattern())),
          stated_lenses_(camera::rectified_lenses(stated)) {}

    types::StereoMatches matches(int frame_index) const {
        const auto frame = recording_.frame(frame_index);
        if (!frame) return {};
        types::StereoMatches found = features::match_misaligned_stereo(camera::synchronise_pair(
            rectifier_.rectify(*frame), exposure_motion_at(recording_, rectifier_, *frame)));
        for (types::StereoMatch& match : found) {
            match.left_px = as_stated(0, match.left_px);
            match.right_px = as_stated(1, match.right_px);
        }
        return found;
    }

private:
    Eigen::Vector2d as_stated(std::size_t side, const Eigen::Vector2d& pixel) const {
        return stated_lenses_[side].rectified_px(
            stated_rectified_, lenses_[side].recorded_px(rectifier_.rig(), pixel));
    }

    const types::Recording& recording_;
    camera::Rectifier rectifier_;
    std::array<camera::RectifiedLens, 2> lenses_;
    types::RectifiedRig stated_rectified_;
    std::array<camera::RectifiedLens, 2> stated_lenses_;
};

types::StereoMatches spread_matches(const PairMatcher& matcher,
                                    int num_frames,
                                    int num_threads,
                                    const base::ProgressCallback& progress) {
    const std::vector<int> frames = spread_frames(num_frames);
    types::StereoMatches all;
    for (std::size_t begin = 0; begin < frames.size() && all.size() < kMinMatches;
         begin += kPairsAtOnce) {
        progress({});
        std::vector<types::StereoMatches> found(std::min(kPairsAtOnce, frames.size() - begin));
        base::for_each_index(num_threads, found.size(), [&](std::size_t i) {
            found[i] = matcher.matches(frames[begin + i]);
        });
        for (const types::StereoMatches& matches : found)
            all.insert(all.end(), matches.begin(), matches.end());
    }
    return all;
}

// Returns the relative pose that the rows of the matches determine.
types::RigAlignment align_rows(const types::Recording& recording,
                               const types::Rig& stated,
                               int num_threads,
                               const base::ProgressCallback& progress) {
    const types::RectifiedRig rectified = camera::rectified_rig(stated, recording.fixed_pattern());
    const auto estimate = [&](const types::Rig& rig) {
        const PairMatcher matcher(recording, stated, rig, num_threads);
        return calibration::estimate_rig_alignment(
            stated,
            rectified,
            spread_matches(matcher, recording.num_frames(), num_threads, progress));
    };
    types::RigAlignment first = estimate(stated);
    if (first.outcome != types::RigAlignment::Outcome::Moved) return first;
    return estimate(
        calibration::changed_rig(stated, first.change));  // patches now fit in shape too
}

bool is_enough(const calibration::RangeSolution& ranges) {
    if (ranges.num_windows == 0 || ranges.outcome.failed() || ranges.outcome.still_moving())
        return false;
    const bool unbiased = std::abs(ranges.bias_px) < 2.0 * ranges.bias_sigma_px;
    return ranges.bias_sigma_px < (unbiased ? kMaxUnbiasedSigma_px : kMaxBiasSigma_px);
}

// Adds what ranges determine, from windows spread over the dive until they suffice, and returns it.
calibration::RangeSolution align_ranges(const types::Recording& recording,
                                        const types::Rig& stated,
                                        int num_threads,
                                        const base::ProgressCallback& progress,
                                        types::RigAlignment& alignment) {
    const camera::Rectifier rectifier(
        calibration::changed_rig(stated, alignment.change), recording.fixed_pattern(), num_threads);
    const std::vector<int> frames = spread_frames(recording.num_frames());
    std::vector<calibration::RangeWindow> windows;
    calibration::RangeSolution ranges;
    const auto max_windows =
        std::min(frames.size(),
                 std::max(kWindowsAtOnce,
                          static_cast<std::size_t>(recording.num_frames() / kFramesPerWindow)));
    for (std::size_t begin = 0; begin < max_windows; begin += kWindowsAtOnce) {
        progress({});
        const auto end = std::min(begin + kWindowsAtOnce, frames.size());
        const auto tracked = track_windows(recording,
                                           rectifier,
                                           {frames.begin() + static_cast<std::ptrdiff_t>(begin),
                                            frames.begin() + static_cast<std::ptrdiff_t>(end)},
                                           num_threads);
        windows.insert(windows.end(), tracked.begin(), tracked.end());
        ranges = calibration::solve_ranges(rectifier.rig(),
                                           windows,
                                           calibration::expected_ranges(),
                                           calibration::expected_range_sigmas());
        if (is_enough(ranges)) break;
    }
    calibration::add_ranges(stated, rectifier.rig(), ranges, alignment);
    return ranges;
}

bool is_determined(const types::RigAlignment& alignment) {
    using Outcome = types::RigAlignment::Outcome;
    return alignment.outcome == Outcome::AsStated || alignment.outcome == Outcome::Moved;
}

void clear_change(types::RigAlignment& alignment) {
    alignment.change = {};
    alignment.sigmas.setZero();
}

// The alignment found if a rig is taken as the stated calibration, and how well it fits.
struct Aligned {
    types::RigAlignment alignment;
    int num_ranges = 0;  // inliers
    double disparity_bias_rad = 0.0;
    double range_error_rad = 0.0;  // robust standard deviations
    double row_error_rad = 0.0;

    double inlier_share() const {
        return alignment.num_matches == 0
                   ? 0.0
                   : static_cast<double>(alignment.num_inliers) / alignment.num_matches;
    }
};

Aligned aligned(const types::Recording& recording,
                const types::Rig& stated,
                int num_threads,
                const base::ProgressCallback& progress) {
    using Outcome = types::RigAlignment::Outcome;
    const types::RigAlignment rows = align_rows(recording, stated, num_threads, progress);
    Aligned result{rows};
    if (!is_determined(rows)) return result;
    types::RigAlignment& alignment = result.alignment;
    if (rows.outcome == Outcome::AsStated) clear_change(alignment);  // reported, never applied
    const calibration::RangeSolution ranges =
        align_ranges(recording, stated, num_threads, progress, alignment);
    if (alignment.outcome == Outcome::AsStated) {
        alignment.change = rows.change;
        alignment.sigmas = rows.sigmas;
    }
    if (ranges.outcome.failed()) return result;
    const double focal_px = camera::rectified_rig(stated, recording.fixed_pattern()).focal_px;
    result.num_ranges = ranges.num_matches;
    result.disparity_bias_rad = ranges.bias_px / focal_px;
    result.range_error_rad = ranges.error_px / focal_px;
    result.row_error_rad = rows.row_error_px / focal_px;
    return result;
}

// Returns nullopt where such cameras cannot be rectified.
std::optional<Aligned> aligned_if_possible(const types::Recording& recording,
                                           const types::Rig& rig,
                                           int num_threads,
                                           const base::ProgressCallback& progress) {
    try {
        return aligned(recording, rig, num_threads, progress);
    } catch (const Error& error) {
        if (error.code() != ErrorCode::BadData) throw;
        return std::nullopt;
    }
}

// The wrong medium puts disparities further off than most knocks and careless calibrations do.
bool may_be_other_medium(const Aligned& as_stated) {
    return as_stated.num_ranges >= kMinRanges &&
           std::abs(as_stated.disparity_bias_rad) > kMinBias_rad;
}

// Another focal length changes angles, and so errors, by a quarter without fitting any better.
bool fits_much_better(const Aligned& other, const Aligned& as_stated) {
    if (other.num_ranges < kMinRanges ||
        other.inlier_share() < as_stated.inlier_share() - kMaxInliersLost)
        return false;
    const double ranges = other.range_error_rad / as_stated.range_error_rad;
    const double rows = other.row_error_rad / as_stated.row_error_rad;
    return std::max(ranges, rows) < kMaxErrorRatio && ranges * rows < kMaxErrorProduct;
}

// Returns the cameras aligned in the medium that fits best, or as stated.
Aligned in_best_medium(const types::Recording& recording,
                       const Aligned& as_stated,
                       int num_threads,
                       const base::ProgressCallback& progress) {
    Aligned best = as_stated;
    for (const types::MediumChange& medium : kOtherMedia) {
        const types::Rig rig = calibration::rig_in_medium(recording.rig(), medium);
        auto other = aligned_if_possible(recording, rig, num_threads, progress);
        if (!other || !fits_much_better(*other, as_stated) ||
            (!best.alignment.change.medium.is_none() &&
             other->range_error_rad > best.range_error_rad))
            continue;
        if (other->alignment.outcome == types::RigAlignment::Outcome::AsStated)
            clear_change(other->alignment);
        other->alignment.change.medium = medium;
        other->alignment.outcome = types::RigAlignment::Outcome::Moved;
        best = *other;
    }
    return best;
}

// Returns the median depth of what pairs spread over the dive show; 0 if they show too little.
double surveyed_depth_m(const types::Recording& recording,
                        int num_threads,
                        const base::ProgressCallback& progress) {
    const types::Rig& rig = recording.rig();
    const types::RectifiedRig rectified = camera::rectified_rig(rig, recording.fixed_pattern());
    const PairMatcher matcher(recording, rig, rig, num_threads);
    std::vector<double> depths_m;
    for (const types::StereoMatch& match :
         spread_matches(matcher, recording.num_frames(), num_threads, progress)) {
        const double disparity_px = match.left_px.x() - match.right_px.x();
        if (disparity_px > kMinSurveyed_px) depths_m.push_back(rectified.depth_m(disparity_px));
    }
    return depths_m.size() < kMinSurveyed ? 0.0 : stats::median(std::move(depths_m));
}

// Returns the alignment of cameras behind described ports, rectified for the depth that the survey
// shows. What they record in is known, so no other medium is tried.
types::RigAlignment aligned_behind_ports(const types::Recording& recording,
                                         int num_threads,
                                         const base::ProgressCallback& progress) {
    const double depth_m = surveyed_depth_m(recording, num_threads, progress);
    const types::Rig rig =
        depth_m > 0.0 ? camera::with_reference_depth(recording.rig(), depth_m) : recording.rig();
    types::RigAlignment alignment = aligned(recording, rig, num_threads, progress).alignment;
    alignment.reference_depth_m = depth_m;
    return alignment;
}

}  // namespace

types::RigAlignment align_cameras(const types::Recording& recording,
                                  int num_threads,
                                  const base::ProgressCallback& progress) {
    if (camera::has_port(recording.rig()))
        return aligned_behind_ports(recording, num_threads, progress);
    const Aligned as_stated = aligned(recording, recording.rig(), num_threads, progress);
    if (!may_be_other_medium(as_stated)) return as_stated.alignment;
    return in_best_medium(recording, as_stated, num_threads, progress).alignment;
}

}  // namespace divemesh::pipeline
