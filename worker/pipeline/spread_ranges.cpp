#include "worker/pipeline/spread_ranges.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "worker/calibration/stereo_alignment.hpp"
#include "worker/camera/rectifier.hpp"
#include "worker/pipeline/range_windows.hpp"

namespace divemesh::pipeline {
namespace {

constexpr std::size_t kWindowsAtOnce = 6;
constexpr int kFramesPerWindow = 8;  // of the span; more windows would read frames twice
// Windows are added until the disparity bias is known this well; the second value is for a bias
// that is not significant.
constexpr double kMaxBiasSigma_px = 0.04;
constexpr double kMaxUnbiasedSigma_px = 0.12;

bool is_enough(const calibration::RangeSolution& ranges) {
    if (ranges.num_windows == 0 || ranges.outcome.failed() || ranges.outcome.still_moving())
        return false;
    const bool unbiased = std::abs(ranges.bias_px) < 2.0 * ranges.bias_sigma_px;
    return ranges.bias_sigma_px < (unbiased ? kMaxUnbiasedSigma_px : kMaxBiasSigma_px);
}

}  // namespace

calibration::RangeSolution solve_spread_ranges(const types::Recording& recording,
                                               const types::Rig& rig,
                                               const FrameSpan& span,
                                               const calibration::RangeUnknowns& sigmas,
                                               int num_threads,
                                               const base::ProgressCallback& progress) {
    const camera::Rectifier rectifier(rig, recording.fixed_pattern(), num_threads);
    const std::vector<int> frames = spread_frames(span);
    std::vector<calibration::RangeWindow> windows;
    calibration::RangeSolution ranges;
    const auto max_windows =
        std::min(frames.size(),
                 std::max(kWindowsAtOnce, static_cast<std::size_t>(span.num / kFramesPerWindow)));
    for (std::size_t begin = 0; begin < max_windows; begin += kWindowsAtOnce) {
        progress({});
        const auto end = std::min(begin + kWindowsAtOnce, frames.size());
        const auto tracked = track_windows(recording,
                                           rectifier,
                                           {frames.begin() + static_cast<std::ptrdiff_t>(begin),
                                            frames.begin() + static_cast<std::ptrdiff_t>(end)},
                                           span.first + span.num,
                                           num_threads);
        windows.insert(windows.end(), tracked.begin(), tracked.end());
        ranges = calibration::solve_ranges(
            rectifier.rig(), windows, calibration::expected_ranges(), sigmas);
        if (is_enough(ranges)) break;
    }
    return ranges;
}

}  // namespace divemesh::pipeline
