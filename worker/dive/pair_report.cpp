#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "worker/base/seconds.hpp"
#include "worker/base/text.hpp"
#include "worker/dive/pair_frames.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::dive {
namespace {

constexpr const char* kRightRows = "mav0/cam1/data.csv";
constexpr std::int64_t kReportedOffset_ns = 1'000'000;
constexpr std::int64_t kClocksOffset_ns = 5'000'000;  // as well as the images tell the difference

std::string range(const std::vector<CameraRow>& rows) {
    return std::to_string(rows.front().timestamp_ns) + " to " +
           std::to_string(rows.back().timestamp_ns);
}

void report_no_pair(const CameraImages& images, FindingLog& findings) {
    findings.error("left_right_no_overlap",
                   kRightRows,
                   "no left image has a right image of the same time, and the images do not show "
                   "how the clocks of the cameras differ: left " +
                       range(images.left) + ", right " + range(images.right),
                   "Record both cameras with the same clock, or move the timestamps of one by the "
                   "difference, for example from a flash that both cameras see.");
}

// Says how well the images confirm the difference of the clocks.
std::string confirmation_of(const StereoDelay& delay) {
    if (delay.is_determined)
        return "; the images confirm it to " + base::fixed(std::max(1.0, 2e3 * delay.sigma_s), 0) +
               " ms";
    if (!delay.share_fitting) return "; the images show too little to confirm it";
    return "; left and right images match, but move too little, or too far from one to the next, "
           "to measure it";
}

void report_clocks(const PairedFrames& frames, FindingLog& findings) {
    if (frames.clocks.is_zero()) return;
    const auto& clocks = frames.clocks;
    const double start_s = base::to_s(clocks.offset_ns);
    const double end_s = start_s + clocks.drift * base::to_s(frames.pairs.back().timestamp_ns -
                                                             frames.pairs.front().timestamp_ns);
    const std::string what = clocks.drift == 0.0
                                 ? "there is a constant difference of " + base::fixed(start_s, 3) +
                                       " s between the clocks of the cameras"
                                 : "the clocks of the cameras differ by " +
                                       base::fixed(start_s, 3) + " s at the start and " +
                                       base::fixed(end_s, 3) + " s at the end (a drift of " +
                                       base::fixed(1e6 * clocks.drift, 0) + " parts per million)";
    findings.warning("camera_clocks_differ",
                     kRightRows,
                     what + " (right minus left). Images are paired using this difference" +
                         confirmation_of(frames.delay) +
                         (frames.has_right_clock
                              ? "; frames have the timestamps of cam1, as the IMU follows those"
                              : ""),
                     "Set both cameras by one clock, or trigger them together.");
    if (!frames.delay.share_fitting)
        findings.warning("pairs_unconfirmed",
                         kRightRows,
                         "images are paired by their timestamps alone: they show too few features "
                         "to tell whether left and right ones are of the same time",
                         "Trigger both cameras together, and keep the bottom or the wall in view.");
}

// Says what a delay does: the rig moves on, so the baseline seems longer or shorter.
std::string effect_of(double delay_s, const StereoDelay& seen, double baseline_m) {
    if (!(seen.speed_m_s > 0.0)) return "";
    return ": at " + base::fixed(seen.speed_m_s, 2) + " m/s that is " +
           base::fixed(1e3 * delay_s * seen.speed_m_s, 1) + " mm of a baseline of " +
           base::fixed(1e3 * baseline_m, 0) + " mm, and " +
           base::fixed(delay_s * seen.flow_px_s, 1) + " px of disparity";
}

// Says what the images tell about gaps that vary by the timestamps.
std::string opinion_on_gaps(const PairedFrames& frames) {
    const StereoDelay& delay = frames.delay;
    if (delay.is_significant())
        return "to which the images add " + base::fixed(1e3 * delay.delay_s, 1) + " ms (+- " +
               base::fixed(2e3 * delay.sigma_s, 1) + " ms)";
    return frames.gaps == PairGaps::Confirmed ? "as the images confirm"
                                              : "and the images show too little to confirm it";
}

void report_varying_gaps(const PairedFrames& frames, double baseline_m, FindingLog& findings) {
    std::vector<double> delays_s;
    delays_s.reserve(frames.pairs.size());
    for (const FramePair& pair : frames.pairs)
        delays_s.push_back(std::abs(frames.right_delay_s(pair)));
    const double max_s = *std::ranges::max_element(delays_s);
    findings.warning("frames_unsynchronised",
                     kRightRows,
                     "the time between left and right images varies from pair to pair by their "
                     "timestamps, " +
                         opinion_on_gaps(frames) + ". It is " +
                         base::fixed(1e3 * stats::median(delays_s), 1) + " ms in the median, and " +
                         base::fixed(1e3 * max_s, 1) + " ms at most" +
                         effect_of(max_s, frames.delay, baseline_m) +
                         ". All presets except paper correct each pair for the motion in between",
                     "Trigger both cameras together, or move slowly.");
}

void report_delay(const PairedFrames& frames, double baseline_m, FindingLog& findings) {
    const StereoDelay& delay = frames.delay;
    if (frames.uses_gaps()) return report_varying_gaps(frames, baseline_m, findings);
    if (delay.is_significant())
        return findings.warning(
            "frames_unsynchronised",
            kRightRows,
            "right images were exposed " + base::fixed(1e3 * std::abs(delay.delay_s), 1) + " ms " +
                (delay.delay_s > 0.0 ? "after" : "before") + " the left ones of their pairs (+- " +
                base::fixed(2e3 * delay.sigma_s, 1) + " ms, by the images)" +
                effect_of(std::abs(delay.delay_s), delay, baseline_m) +
                ". All presets except paper correct for the motion in between",
            "Trigger both cameras together, or move slowly.");
    std::int64_t max_offset_ns = 0;
    for (const FramePair& pair : frames.pairs)
        max_offset_ns = std::max(max_offset_ns, std::abs(frames.gap_ns(pair)));
    if (max_offset_ns <= (frames.clocks.is_zero() ? kReportedOffset_ns : kClocksOffset_ns)) return;
    findings.warning("frames_unsynchronised",
                     kRightRows,
                     "left and right images are up to " +
                         base::fixed(1e3 * base::to_s(max_offset_ns), 2) + " ms apart" +
                         (frames.gaps == PairGaps::Contradicted
                              ? " by their timestamps, but the images fit better if all pairs were "
                                "exposed together: they are used as such"
                              : effect_of(base::to_s(max_offset_ns), delay, baseline_m)),
                     "Trigger both cameras together, or move slowly.");
}

}  // namespace

void report_pairs(const PairedFrames& frames,
                  const CameraImages& images,
                  double baseline_m,
                  FindingLog& findings) {
    if (images.left.empty() || images.right.empty()) return;
    if (frames.pairs.empty()) return report_no_pair(images, findings);
    report_clocks(frames, findings);
    report_delay(frames, baseline_m, findings);
    const std::size_t num_left = images.left.size() - frames.pairs.size();
    const std::size_t num_right = images.right.size() - frames.pairs.size();
    if (num_left + num_right > 0)
        findings.warning("frames_unmatched",
                         kRightRows,
                         std::to_string(num_left) + " left and " + std::to_string(num_right) +
                             " right images have no partner and are ignored",
                         "Trigger both cameras together.");
}

}  // namespace divemesh::dive
