#include "worker/pipeline/tracking_findings.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>

#include "worker/base/seconds.hpp"
#include "worker/base/text.hpp"
#include "worker/pipeline/measured_poses.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::pipeline {
namespace {

// Share of the motions from frame to frame that vision constrains. Below a tenth, the path comes
// from the motion model and there is hardly any map.
constexpr double kMinShare = 0.1;
// Share of the frames without a measured pose. Where it is larger, the path is restricted.
constexpr double kWarningShare = 0.05;
constexpr std::size_t kMaxLosses = 5;  // reported one by one
// A frame with texture has hundreds of features.
constexpr double kMinFeatures = 60.0;
// Share of the features of the left image that are found in the right one too.
constexpr double kMinShareWithDepth = 0.3;
// Share of an image that the next one sees too. The tracker follows features down to about half;
// above it the cause lies elsewhere.
constexpr double kMinOverlap = 0.6;
constexpr int kGridSize = 12;
constexpr double kPausePeriods = 5.0;
// Pairs that could not be used are missed from so long a run on: a camera that lacks or repeats
// some images is only slower.
constexpr double kMissed_s = 1.0;
constexpr double kMissedPeriods = 5.0;

// Consecutive frames whose motions from the frame before were not measured, numbered from 0 among
// the frames that decode.
struct Loss {
    std::size_t first = 0;
    std::size_t last = 0;
    std::size_t num_unmeasured = 0;  // frames, among them, without a measured pose
    double duration_s = 0.0;         // without a measured motion
};

bool is_shorter(const Loss& a, const Loss& b) { return a.duration_s < b.duration_s; }

std::vector<Loss> losses_of(const types::Track& track, const std::vector<bool>& measured) {
    std::vector<Loss> losses;
    for (std::size_t i = 0; i < track.motions.size(); ++i) {
        const bool lost = i == 0 ? !measured[0] : track.motions[i] == types::MotionSource::Nothing;
        if (!lost) continue;
        if (losses.empty() || losses.back().last + 1 != i) losses.push_back({i, i, 0, 0.0});
        Loss& loss = losses.back();
        loss.last = i;
        if (!measured[i]) ++loss.num_unmeasured;
        loss.duration_s =
            base::to_s(track.odometry[i].timestamp_ns -
                       track.odometry[loss.first > 0 ? loss.first - 1 : 0].timestamp_ns);
    }
    return losses;
}

double median_period_s(const types::Track& track) {
    std::vector<double> periods_s;
    for (std::size_t i = 1; i < track.odometry.size(); ++i)
        periods_s.push_back(
            base::to_s(track.odometry[i].timestamp_ns - track.odometry[i - 1].timestamp_ns));
    return stats::upper_median(std::move(periods_s));
}

// Returns which share of an image the next one would see, by the motion that was expected and the
// median depth of the dive.
double expected_overlap(const types::Track& track, std::size_t next) {
    const types::RectifiedRig& rig = track.rig;
    const double depth_m = track.statistics.median_depth_m;
    if (next == 0 || !(depth_m > 0.0)) return 1.0;
    const Eigen::Isometry3d T_next_previous =
        (track.odometry[next].T_world_imu * rig.T_imu_cam).inverse() *
        (track.odometry[next - 1].T_world_imu * rig.T_imu_cam);
    int num_seen = 0;
    for (int i = 0; i < kGridSize * kGridSize; ++i) {
        const int column = i % kGridSize;
        const int row = i / kGridSize;
        const Eigen::Vector3d p_next =
            T_next_previous * rig.point_cam((column + 0.5) * rig.width_px / kGridSize,
                                            (row + 0.5) * rig.height_px / kGridSize,
                                            depth_m);
        if (!(p_next.z() > 0.0)) continue;
        const Eigen::Vector2d pixel = rig.pixel(p_next);
        if (pixel.x() >= 0.0 && pixel.x() < rig.width_px && pixel.y() >= 0.0 &&
            pixel.y() < rig.height_px)
            ++num_seen;
    }
    return static_cast<double>(num_seen) / (kGridSize * kGridSize);
}

double median_count(const types::Track& track,
                    const Loss& loss,
                    std::int32_t types::FrameFeatures::*count) {
    std::vector<double> counts;
    for (std::size_t i = loss.first; i <= loss.last; ++i)
        counts.push_back(static_cast<double>(track.features[i].*count));
    return stats::upper_median(std::move(counts));
}

constexpr const char* kMendImages =
    "the findings about images say why; copy unreadable ones from the recorder again, and check "
    "the "
    "cables and the card of a camera that hangs";

struct Cause {
    std::string text;
    std::string remedy;
};

Cause too_little_overlap(double overlap, double interval_s) {
    const double needed_hz = std::ceil((1.0 - overlap) / ((1.0 - kMinOverlap) * interval_s));
    return {"consecutive images overlap by only " + base::fixed(100.0 * overlap, 0) + " %",
            "swim and turn more slowly, or record above " + base::fixed(needed_hz, 0) +
                " pairs a second"};
}

// Returns how long the pairs of a run were missed, at the rate of the frames that were used; 0 if
// they were not. A recorder that paused recorded no pairs.
double missed_s(const types::UnusablePairs& run, double period_s) {
    const double lost_s = std::min(run.duration_s, static_cast<double>(run.num) * period_s);
    return lost_s > std::max(kMissed_s, kMissedPeriods * period_s) ? lost_s : 0.0;
}

// Returns the pairs before a frame that could not be used, if they were missed.
const types::UnusablePairs* unusable_before(const types::Track& track, std::size_t frame) {
    const auto run = std::ranges::find(
        track.unusable, static_cast<std::int64_t>(frame), &types::UnusablePairs::next_frame);
    return run != track.unusable.end() && missed_s(*run, median_period_s(track)) > 0.0 ? &*run
                                                                                       : nullptr;
}

// Returns the likely cause of a loss.
Cause cause_of(const types::Track& track, const Loss& loss) {
    const double num_features = median_count(track, loss, &types::FrameFeatures::num_features);
    const double num_with_depth = median_count(track, loss, &types::FrameFeatures::num_with_depth);
    if (num_features < kMinFeatures)
        return {"the images show hardly any texture (" + base::fixed(num_features, 0) +
                    " features an image)",
                "keep textured ground in view and in the light; check focus, exposure and a fogged "
                "port"};
    if (num_with_depth < kMinShareWithDepth * num_features)
        return {"only " + base::fixed(100.0 * num_with_depth / num_features, 0) +
                    " % of the features of the left image were found in the right one",
                "check that both images are equally sharp and bright, simultaneous and fit the "
                "calibration (divemesh validate DIVE)"};
    const std::size_t next = std::max<std::size_t>(loss.first, 1);
    const double interval_s =
        base::to_s(track.odometry[next].timestamp_ns - track.odometry[next - 1].timestamp_ns);
    if (const types::UnusablePairs* run = unusable_before(track, next))
        return {"none of " + std::to_string(run->num) + " pairs could be used for " +
                    base::fixed(interval_s, 1) + " s",
                kMendImages};
    if (loss.first == loss.last && interval_s > kPausePeriods * median_period_s(track))
        return {"no image was recorded for " + base::fixed(interval_s, 1) + " s",
                "record without pauses, or come back to a place that was already recorded"};
    const double overlap = expected_overlap(track, next);
    if (overlap < kMinOverlap && interval_s > 0.0) return too_little_overlap(overlap, interval_s);
    return {"features could not be followed to the next image, " + base::fixed(interval_s, 2) +
                " s later",
            kTrackBetter};
}

std::string range_of(const Loss& loss) {
    return loss.first == loss.last
               ? "frame " + std::to_string(loss.first)
               : "frames " + std::to_string(loss.first) + " to " + std::to_string(loss.last);
}

Finding finding_on(const types::Track& track, const Loss& loss, Severity severity) {
    const Cause cause = cause_of(track, loss);
    return {severity,
            "tracking_lost",
            range_of(loss),
            "lost for " + base::fixed(loss.duration_s, 1) + " s: " + cause.text,
            cause.remedy};
}

std::string motions_text(const types::TrackStatistics& track) {
    const std::int64_t num_motions = std::max<std::int64_t>(0, track.num_frames - 1);
    return std::to_string(track.num_frames - track.num_frames_tracked) + " of " +
           std::to_string(num_motions) + " motions from frame to frame";
}

Finding finding_on_all(const types::Track& track,
                       const std::vector<Loss>& losses,
                       Severity severity) {
    std::size_t num_unmeasured = 0;
    double duration_s = 0.0;
    for (const Loss& loss : losses) {
        num_unmeasured += loss.num_unmeasured;
        duration_s += loss.duration_s;
    }
    std::string message = "the scene was lost " + std::to_string(losses.size()) +
                          (losses.size() == 1 ? " time" : " times") + ", for " +
                          base::fixed(duration_s, 1) + " s in all";
    const double share =
        static_cast<double>(num_unmeasured) / static_cast<double>(track.motions.size());
    if (num_unmeasured > 0)
        message += ": " + std::to_string(num_unmeasured) + " of " +
                   std::to_string(track.motions.size()) + " frames (" +
                   base::fixed(100.0 * share, 1) +
                   " %) have no measured pose; predictions of them are in "
                   "trajectory_predicted.tum";
    return {severity, "tracking_lost", "", message, losses.size() > kMaxLosses ? kTrackBetter : ""};
}

// The pairs that could not be used.
struct Missed {
    std::int64_t num_pairs = 0;   // all
    std::int64_t num_missed = 0;  // those that could not be used
    double duration_s = 0.0;      // that is missed
    double share = 0.0;           // of the dive's duration
    double longest_s = 0.0;       // at one time
    const types::UnusablePairs* longest = nullptr;
};

Missed missed_by(const types::Track& track) {
    Missed missed;
    double duration_s = 0.0;  // of the dive
    if (!track.odometry.empty())
        duration_s =
            base::to_s(track.odometry.back().timestamp_ns - track.odometry.front().timestamp_ns);
    const double period_s = median_period_s(track);
    for (const types::UnusablePairs& run : track.unusable) {
        missed.num_missed += run.num;
        if (run.next_frame == 0 || run.next_frame == std::ssize(track.odometry))
            duration_s += run.duration_s;
        const double run_s = missed_s(run, period_s);
        missed.duration_s += run_s;
        if (run_s <= missed.longest_s) continue;
        missed.longest_s = run_s;
        missed.longest = &run;
    }
    missed.num_pairs = track.statistics.num_frames + missed.num_missed;
    if (duration_s > 0.0) missed.share = missed.duration_s / duration_s;
    return missed;
}

std::string pairs_text(const Missed& missed) {
    return std::to_string(missed.num_missed) + " of " + std::to_string(missed.num_pairs) +
           " pairs could not be used";
}

Finding nothing_usable(const Missed& missed) {
    return {Severity::Error,
            "nothing_reconstructed",
            "",
            pairs_text(missed) + ", so there is no model",
            kMendImages};
}

std::optional<Finding> images_unusable(const types::Track& track) {
    const Missed missed = missed_by(track);
    if (missed.longest == nullptr) return std::nullopt;
    const types::UnusablePairs& longest = *missed.longest;
    return Finding{missed.share > kWarningShare ? Severity::Warning : Severity::Info,
                   "images_unusable",
                   "pairs " + std::to_string(longest.first) + " to " +
                       std::to_string(longest.first + longest.num - 1),
                   pairs_text(missed) + ": " + base::fixed(missed.duration_s, 1) + " s (" +
                       base::fixed(100.0 * missed.share, 1) +
                       " %) of the dive are missing, at one time " +
                       base::fixed(missed.longest_s, 1) + " s",
                   kMendImages};
}

}  // namespace

std::optional<Finding> too_little_tracked(const types::Track& track) {
    const types::TrackStatistics& statistics = track.statistics;
    const Missed missed = missed_by(track);
    if (missed.num_pairs < 2) return std::nullopt;
    if (statistics.num_frames < 2 || 1.0 - missed.share < kMinShare) return nothing_usable(missed);
    const double share = static_cast<double>(statistics.num_frames_tracked - 1) /
                         static_cast<double>(statistics.num_frames - 1);
    if ((1.0 - missed.share) * share >= kMinShare) return std::nullopt;
    if (share >= kMinShare) return nothing_usable(missed);
    const std::vector<Loss> losses =
        losses_of(track, measured_frames(track.odometry, track.breaks_ns, track.keyframes));
    const auto longest = std::max_element(losses.begin(), losses.end(), is_shorter);
    // Without a loss the IMU alone measured what vision did not.
    const Cause cause = longest == losses.end()
                            ? Cause{"vision measured single motions only", kTrackBetter}
                            : cause_of(track, *longest);
    return Finding{Severity::Error,
                   "nothing_reconstructed",
                   "",
                   motions_text(statistics) + " (" + base::fixed(100.0 * (1.0 - share), 1) +
                       " %) could not be measured by vision, so there is no model: " + cause.text,
                   cause.remedy};
}

std::vector<Finding> tracking_findings(const types::Track& track) {
    const std::vector<bool> measured =
        measured_frames(track.odometry, track.breaks_ns, track.keyframes);
    std::vector<Finding> findings;
    if (auto finding = images_unusable(track)) findings.push_back(std::move(*finding));
    std::vector<Loss> losses = losses_of(track, measured);
    if (losses.empty()) return findings;
    const auto num_unmeasured = std::count(measured.begin(), measured.end(), false);
    const bool many =
        static_cast<double>(num_unmeasured) > kWarningShare * static_cast<double>(measured.size());
    const Severity severity = many ? Severity::Warning : Severity::Info;
    findings.push_back(finding_on_all(track, losses, severity));
    std::stable_sort(losses.begin(), losses.end(), [](const Loss& a, const Loss& b) {
        return is_shorter(b, a);
    });
    losses.resize(std::min(losses.size(), kMaxLosses));
    std::sort(losses.begin(), losses.end(), [](const Loss& a, const Loss& b) {
        return a.first < b.first;
    });
    for (const Loss& loss : losses) findings.push_back(finding_on(track, loss, severity));
    return findings;
}

Finding large_images_finding(int reduction) {
    return {
        Severity::Info,
        "images_reduced",
        "mav0/cam0/data",
        "the images are wider than the option max_width_px, so the dive was reconstructed at 1/" +
            std::to_string(reduction) +
            " of their size; markers are searched in the smaller images too",
        "to use every pixel, in several times the time, set max_width_px=0"};
}

Finding soft_images_finding(int reduction) {
    return {
        Severity::Warning,
        "images_soft",
        "mav0/cam0/data",
        "vision lost the scene in larger images and followed it in images of 1/" +
            std::to_string(reduction) +
            " of the size, so the dive was reconstructed at that size and its surface is coarser: "
            "turbid water, or lenses out of focus",
        "go nearer, use more light from the side, or check the focus"};
}

}  // namespace divemesh::pipeline
