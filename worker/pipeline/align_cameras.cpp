#include "worker/pipeline/align_cameras.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "worker/base/angle.hpp"
#include "worker/base/parallel.hpp"
#include "worker/base/text.hpp"
#include "worker/calibration/stereo_alignment.hpp"
#include "worker/camera/rectified_lens.hpp"
#include "worker/camera/rectifier.hpp"
#include "worker/camera/synchronise_pair.hpp"
#include "worker/features/match_misaligned_stereo.hpp"
#include "worker/pipeline/range_windows.hpp"

namespace divemesh::pipeline {
namespace {

constexpr std::size_t kMaxPairs = 48;
constexpr std::size_t kPairsAtOnce = 12;  // also the fewest of a longer dive
constexpr std::size_t kEnoughMatches = 2000;
constexpr std::size_t kWindowsAtOnce = 6;
constexpr int kFramesPerWindow = 8;  // of the dive; more windows would read frames twice
// Windows are added until the bias of disparities is known this well, or hardly is one.
constexpr double kEnoughBiasSigma_px = 0.04;
constexpr double kNoBiasSigma_px = 0.12;
constexpr double kTold_px = 0.7;  // findings begin here

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

// Matches pairs after rectification with one rig and returns them as in another's.
class PairMatcher {
public:
    PairMatcher(const types::Recording& recording, const types::Rig& rig)
        : recording_(recording),
          rectifier_(rig, recording.fixed_pattern()),
          lenses_(camera::rectified_lenses(rig)),
          stated_rectified_(camera::Rectifier(recording.rig()).rig()),
          stated_lenses_(camera::rectified_lenses(recording.rig())) {}

    types::StereoMatches matches(int frame_index) const {
        const auto frame = recording_.frame(frame_index);
        if (!frame) return {};
        types::StereoMatches found = features::match_misaligned_stereo(camera::synchronise_pair(
            rectifier_.rectify(*frame), exposure_motion_at(recording_, rectifier_, frame_index)));
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
    for (std::size_t begin = 0; begin < frames.size() && all.size() < kEnoughMatches;
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

// Returns how the right camera stands by the rows of matches.
types::RigAlignment align_rows(const types::Recording& recording,
                               int num_threads,
                               const base::ProgressCallback& progress) {
    const types::Rig& stated = recording.rig();
    const types::RectifiedRig rectified = camera::Rectifier(stated).rig();
    const auto estimate = [&](const types::Rig& rig) {
        const PairMatcher matcher(recording, rig);
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
    if (ranges.num_windows == 0) return false;
    const bool unbiased = std::abs(ranges.bias_px) < 2.0 * ranges.bias_sigma_px;
    return ranges.bias_sigma_px < (unbiased ? kNoBiasSigma_px : kEnoughBiasSigma_px);
}

// Adds what ranges tell, from windows spread over the dive until they tell enough.
void align_ranges(const types::Recording& recording,
                  int num_threads,
                  const base::ProgressCallback& progress,
                  types::RigAlignment& alignment) {
    const camera::Rectifier rectifier(calibration::changed_rig(recording.rig(), alignment.change),
                                      recording.fixed_pattern());
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
    calibration::add_ranges(recording.rig(), rectifier.rig(), ranges, alignment);
}

std::string degrees(double angle_rad) { return base::fixed(base::kDegPerRad * angle_rad, 2); }

// Returns what the change does to disparities, "" where nothing tells it.
std::string disparities_off(const types::RigAlignment& alignment) {
    if (!alignment.moves_disparities()) return "";
    const double bias_px = alignment.disparity_bias_px;
    return ", and all disparities are " + base::fixed(std::abs(bias_px), 1) + " +- " +
           base::fixed(alignment.disparity_bias_sigma_px, 1) + " px too " +
           (bias_px > 0.0 ? "large" : "small") + " (principal point " +
           base::fixed(alignment.change.values[types::RigChange::kCentre], 1) + " px off)";
}

Finding moved_finding(const types::RigAlignment& alignment) {
    const auto& turned = alignment.change.values;
    return {Severity::Warning,
            "stereo_mismatch",
            "mav0/cam1/sensor.yaml",
            "the right camera does not stand where the calibration has it: it has turned by " +
                degrees(turned.head<3>().norm()) + " degrees (pitch " + degrees(turned[0]) +
                ", yaw " + degrees(turned[1]) + ", roll " + degrees(turned[2]) +
                "), so matching points in the left and right images lie " +
                base::fixed(alignment.row_shift_px, 1) + " px (RMS) off their rows" +
                disparities_off(alignment),
            "The reconstruction estimates this from the images and corrects it (option "
            "align_cameras). Calibrate the stereo pair again, and check that the cameras are "
            "fixed tightly."};
}

Finding inconsistent_finding(const types::RigAlignment& alignment) {
    return {Severity::Warning,
            "stereo_inconsistent",
            "mav0/cam1/data",
            "of " + std::to_string(alignment.num_matches) +
                " points found in left and right images, " + std::to_string(alignment.num_inliers) +
                " agree on one position of the cameras, and the rows of a pair differ by " +
                base::fixed(alignment.pair_error_px, 1) + " px (RMS) from pair to pair",
            "Check that both cameras expose at the same time, that both images are sharp, and that "
            "the cameras cannot move against each other."};
}

}  // namespace

types::RigAlignment align_cameras(const types::Recording& recording,
                                  int num_threads,
                                  const base::ProgressCallback& progress) {
    using Outcome = types::RigAlignment::Outcome;
    types::RigAlignment rows = align_rows(recording, num_threads, progress);
    if (rows.outcome != Outcome::AsStated && rows.outcome != Outcome::Moved) return rows;
    types::RigAlignment alignment = rows;
    if (rows.outcome == Outcome::AsStated) {  // reported, never applied
        alignment.change = {};
        alignment.sigmas.setZero();
    }
    align_ranges(recording, num_threads, progress, alignment);
    if (alignment.outcome == Outcome::AsStated) {
        alignment.change = rows.change;
        alignment.sigmas = rows.sigmas;
    }
    return alignment;
}

std::vector<Finding> alignment_findings(const types::RigAlignment& alignment) {
    using Outcome = types::RigAlignment::Outcome;
    if (alignment.outcome == Outcome::Inconsistent) return {inconsistent_finding(alignment)};
    if (alignment.outcome == Outcome::Moved && alignment.shift_px() >= kTold_px)
        return {moved_finding(alignment)};
    return {};
}

}  // namespace divemesh::pipeline
