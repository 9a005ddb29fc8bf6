#include "worker/pipeline/align_parts.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "worker/calibration/row_jump.hpp"
#include "worker/calibration/stereo_alignment.hpp"
#include "worker/camera/rectifier.hpp"
#include "worker/pipeline/spread_ranges.hpp"

namespace divemesh::pipeline {
namespace {

constexpr int kMinFrames = 16;      // of a span that is searched for another jump
constexpr double kMinSudden = 0.5;  // share of the jump
constexpr int kMaxTries = 3;        // frames beside the one wanted, where that shows too little
// Yaws are compared between parts, so that what else bends ranges is the same in both.
constexpr double kYawSigma_rad = 0.0175;
constexpr double kNoSigma = 1e-6;
constexpr double kMinShift_px = 0.3;
constexpr double kSignificant = 3.0;

// A frame, and whether it lies before a jump.
struct Sided {
    int frame = 0;
    bool before = false;
};

// Returns the frame, or one of the next, with its side of a jump; nullopt if they show too little.
std::optional<Sided> side_of(const PairMatcher& matcher,
                             const calibration::RowJump& jump,
                             int frame,
                             int end) {
    for (int i = 0; i < kMaxTries && frame + i < end; ++i)
        if (const auto before = jump.is_before(matcher.matches(frame + i)))
            return Sided{frame + i, *before};
    return std::nullopt;
}

// Returns the first frame after the jump, by bisection between the pairs that told it.
int first_after(const PairMatcher& matcher, const calibration::RowJump& jump) {
    int before = jump.last_before;
    int after = jump.first_after;
    while (after - before > 1) {
        const auto side = side_of(matcher, jump, (before + after) / 2, after);
        if (!side) break;
        (side->before ? before : after) = side->frame;
    }
    return after;
}

// Returns whether the rows go most of the way from one frame to the next, or cannot be told there.
// Those of cameras that sway go a little with each.
bool is_sudden(const PairMatcher& matcher, const calibration::RowJump& jump, int first_after) {
    const auto before = jump.share_after(matcher.matches(first_after - 1));
    const auto after = jump.share_after(matcher.matches(first_after));
    return !before || !after || *after - *before > kMinSudden;
}

void split(const PairMatcher& matcher,
           const types::RectifiedRig& rectified,
           const types::StereoMatches& matches,
           const FrameSpan& span,
           const base::ProgressCallback& progress,
           std::vector<FrameSpan>& found) {
    const auto jump =
        span.num < kMinFrames ? std::nullopt : calibration::find_row_jump(rectified, matches);
    if (!jump) {
        found.push_back(span);
        return;
    }
    progress({});
    const int middle = first_after(matcher, *jump);
    if (!is_sudden(matcher, *jump, middle)) {
        found.push_back(span);
        return;
    }
    const FrameSpan before{span.first, middle - span.first};
    const FrameSpan after{middle, span.first + span.num - middle};
    types::StereoMatches matches_before;
    types::StereoMatches matches_after;
    for (const types::StereoMatch& match : matches)
        (match.frame_index < middle ? matches_before : matches_after).push_back(match);
    split(matcher, rectified, matches_before, before, progress, found);
    split(matcher, rectified, matches_after, after, progress, found);
}

// Yaw of the right camera, and nothing else, as ranges of a span tell it.
calibration::RangeSolution yaw_of(const types::Recording& recording,
                                  const types::Rig& rig,
                                  const FrameSpan& span,
                                  int num_threads,
                                  const base::ProgressCallback& progress) {
    return solve_spread_ranges(
        recording, rig, span, {kYawSigma_rad, kNoSigma, kNoSigma, kNoSigma}, num_threads, progress);
}

void add_yaw(const types::Rig& rig,
             const types::RectifiedRig& rectified,
             const calibration::RangeSolution& in_reference,
             const calibration::RangeSolution& in_part,
             types::RigPart& part) {
    if (in_reference.num_windows == 0 || in_part.num_windows == 0 ||
        in_reference.outcome.failed() || in_part.outcome.failed())
        return;
    const double yaw_rad = in_part.values[0] - in_reference.values[0];
    const double sigma_rad = std::sqrt(in_part.covariance(0, 0) + in_reference.covariance(0, 0));
    if (std::abs(yaw_rad) < std::max(kMinShift_px / rectified.focal_px, kSignificant * sigma_rad))
        return;
    calibration::add_yaw(rig, yaw_rad, part.values);
    part.sigmas[types::RigChange::kYaw] = sigma_rad;
}

types::RigPart align_part(const types::Recording& recording,
                          const types::Rig& rig,
                          const FrameSpan& span,
                          const calibration::RangeSolution& in_reference,
                          int num_threads,
                          const base::ProgressCallback& progress) {
    const types::RectifiedRig rectified = camera::rectified_rig(rig, recording.fixed_pattern());
    const auto turned = [&](const types::RigPart& part) {
        return calibration::changed_rig(rig, {.values = part.values});
    };
    const auto estimate = [&](const types::Rig& as) {
        const PairMatcher matcher(recording, rig, as, num_threads);
        return calibration::estimate_turn(rig, rectified, matcher.spread_matches(span, progress));
    };
    types::RigPart part = estimate(rig);
    if (!part.found) return part;
    // Patches now fit in shape too.
    if (const types::RigPart again = estimate(turned(part)); again.found) part = again;
    add_yaw(turned(part),
            rectified,
            in_reference,
            yaw_of(recording, turned(part), span, num_threads, progress),
            part);
    return part;
}

// Returns the time of the first frame that can be read; 0 if none can.
std::int64_t begin_of(const types::Recording& recording, const FrameSpan& span) {
    for (int frame = span.first; frame < span.first + span.num; ++frame)
        if (const auto recorded = recording.frame(frame)) return recorded->timestamp_ns;
    return 0;
}

}  // namespace

std::vector<FrameSpan> still_spans(const types::Recording& recording,
                                   const types::Rig& rig,
                                   const types::StereoMatches& matches,
                                   int num_threads,
                                   const base::ProgressCallback& progress) {
    const FrameSpan whole{0, recording.num_frames()};
    const types::RectifiedRig rectified = camera::rectified_rig(rig, recording.fixed_pattern());
    if (whole.num < kMinFrames || !calibration::find_row_jump(rectified, matches)) return {whole};
    const PairMatcher matcher(recording, rig, rig, num_threads);
    std::vector<FrameSpan> spans;
    split(matcher, rectified, matcher.many_matches(whole, progress), whole, progress, spans);
    return spans;
}

std::vector<types::RigPart> align_parts(const types::Recording& recording,
                                        const types::Rig& rig,
                                        const std::vector<FrameSpan>& spans,
                                        const FrameSpan& reference,
                                        int num_threads,
                                        const base::ProgressCallback& progress) {
    const calibration::RangeSolution in_reference =
        yaw_of(recording, rig, reference, num_threads, progress);
    std::vector<types::RigPart> parts;
    for (const FrameSpan& span : spans) {
        types::RigPart part;
        if (span.first == reference.first)
            part.found = true;
        else
            part = align_part(recording, rig, span, in_reference, num_threads, progress);
        part.first_frame = span.first;
        part.num_frames = span.num;
        part.from_ns = begin_of(recording, span);
        parts.push_back(part);
    }
    return parts;
}

}  // namespace divemesh::pipeline
