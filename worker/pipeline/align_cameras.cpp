#include "worker/pipeline/align_cameras.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "schemas/error.hpp"
#include "worker/calibration/stereo_alignment.hpp"
#include "worker/camera/rectifier.hpp"
#include "worker/camera/virtual_camera.hpp"
#include "worker/pipeline/align_parts.hpp"
#include "worker/pipeline/pair_matcher.hpp"
#include "worker/pipeline/spread_ranges.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::pipeline {
namespace {

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
constexpr double kMinKnock_px = 0.7;
// Shares of the errors. A right medium left 0.16 to 0.26 of both (product), a wrong one 0.55 and
// more.
constexpr double kMaxErrorRatio = 0.7;
constexpr double kMaxErrorProduct = 0.4;

FrameSpan whole(const types::Recording& recording) { return {0, recording.num_frames()}; }

// The relative pose that rows determine, and the matches that it is from, as rectified with the
// stated rig.
struct AlignedRows {
    types::RigAlignment alignment;
    types::StereoMatches matches;
};

AlignedRows align_rows(const types::Recording& recording,
                       const types::Rig& stated,
                       const FrameSpan& span,
                       int num_threads,
                       const base::ProgressCallback& progress) {
    const types::RectifiedRig rectified = camera::rectified_rig(stated, recording.fixed_pattern());
    const auto estimate = [&](const types::Rig& rig) {
        const PairMatcher matcher(recording, stated, rig, num_threads);
        types::StereoMatches matches = matcher.spread_matches(span, progress);
        return AlignedRows{calibration::estimate_rig_alignment(stated, rectified, matches),
                           std::move(matches)};
    };
    AlignedRows first = estimate(stated);
    if (first.alignment.outcome != types::RigAlignment::Outcome::Moved) return first;
    // Patches now fit in shape too.
    return estimate(calibration::changed_rig(stated, first.alignment.change));
}

bool is_determined(const types::RigAlignment& alignment) {
    using Outcome = types::RigAlignment::Outcome;
    return alignment.outcome == Outcome::AsStated || alignment.outcome == Outcome::Moved;
}

// Returns whether the stated calibration is right but for what calibrations are off by.
bool fits_nearly(const types::RigAlignment& alignment) {
    return is_determined(alignment) && alignment.shift_px() < kMinKnock_px;
}

void clear_change(types::RigAlignment& alignment) {
    alignment.change = {};
    alignment.sigmas.setZero();
}

// The alignment found if a rig is taken as the stated calibration, and how well it fits.
struct Aligned {
    types::RigAlignment alignment;
    types::StereoMatches matches;  // of pairs rectified with that rig
    int num_ranges = 0;            // inliers
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
                const FrameSpan& span,
                int num_threads,
                const base::ProgressCallback& progress) {
    using Outcome = types::RigAlignment::Outcome;
    AlignedRows by_rows = align_rows(recording, stated, span, num_threads, progress);
    const types::RigAlignment& rows = by_rows.alignment;
    Aligned result{rows, std::move(by_rows.matches)};
    if (!is_determined(rows)) return result;
    types::RigAlignment& alignment = result.alignment;
    if (rows.outcome == Outcome::AsStated) clear_change(alignment);  // reported, never applied
    const types::Rig moved = calibration::changed_rig(stated, alignment.change);
    const calibration::RangeSolution ranges = solve_spread_ranges(
        recording, moved, span, calibration::expected_range_sigmas(), num_threads, progress);
    calibration::add_ranges(
        stated, camera::rectified_rig(moved, recording.fixed_pattern()), ranges, alignment);
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
                                           const FrameSpan& span,
                                           int num_threads,
                                           const base::ProgressCallback& progress) {
    try {
        return aligned(recording, rig, span, num_threads, progress);
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
                       const FrameSpan& span,
                       int num_threads,
                       const base::ProgressCallback& progress) {
    Aligned best = as_stated;
    for (const types::MediumChange& medium : kOtherMedia) {
        const types::Rig rig = calibration::rig_in_medium(recording.rig(), medium);
        auto other = aligned_if_possible(recording, rig, span, num_threads, progress);
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
    for (const types::StereoMatch& match : matcher.spread_matches(whole(recording), progress)) {
        const double disparity_px = match.left_px.x() - match.right_px.x();
        if (disparity_px > kMinSurveyed_px) depths_m.push_back(rectified.depth_m(disparity_px));
    }
    return depths_m.size() < kMinSurveyed ? 0.0 : stats::median(std::move(depths_m));
}

// The alignment of the part of a dive that the others are compared with, and all parts.
struct InParts {
    Aligned reference;
    std::vector<FrameSpan> spans;  // one: nothing moved it
    FrameSpan span;                // that `reference` is of
};

InParts aligned_in_parts(const types::Recording& recording,
                         const types::Rig& stated,
                         int num_threads,
                         const base::ProgressCallback& progress) {
    const FrameSpan all = whole(recording);
    InParts result{aligned(recording, stated, all, num_threads, progress), {all}, all};
    std::vector<FrameSpan> spans =
        still_spans(recording, stated, result.reference.matches, num_threads, progress);
    if (spans.size() < 2) return result;
    // Calibrations are made before a dive, so what knocks a camera comes after.
    FrameSpan span = spans.front();
    Aligned reference = aligned(recording, stated, span, num_threads, progress);
    const FrameSpan longest = *std::ranges::max_element(spans, {}, &FrameSpan::num);
    if (!fits_nearly(reference.alignment) && longest.first != span.first) {
        span = longest;
        reference = aligned(recording, stated, span, num_threads, progress);
    }
    if (!is_determined(reference.alignment)) return result;
    return {std::move(reference), std::move(spans), span};
}

types::RigAlignment with_parts(const types::Recording& recording,
                               const types::Rig& stated,
                               const InParts& found,
                               types::RigAlignment alignment,
                               int num_threads,
                               const base::ProgressCallback& progress) {
    if (found.spans.size() < 2) return alignment;
    const bool moved = alignment.outcome == types::RigAlignment::Outcome::Moved;
    alignment.parts =
        align_parts(recording,
                    moved ? calibration::changed_rig(stated, alignment.change) : stated,
                    found.spans,
                    found.span,
                    num_threads,
                    progress);
    return alignment;
}

// Returns the alignment of cameras behind described ports, rectified for the depth that the survey
// shows. What they record in is known, so no other medium is tried.
types::RigAlignment aligned_behind_ports(const types::Recording& recording,
                                         int num_threads,
                                         const base::ProgressCallback& progress) {
    const double depth_m = surveyed_depth_m(recording, num_threads, progress);
    const types::Rig rig =
        depth_m > 0.0 ? camera::with_reference_depth(recording.rig(), depth_m) : recording.rig();
    const InParts found = aligned_in_parts(recording, rig, num_threads, progress);
    types::RigAlignment alignment =
        with_parts(recording, rig, found, found.reference.alignment, num_threads, progress);
    alignment.reference_depth_m = depth_m;
    return alignment;
}

}  // namespace

types::RigAlignment align_cameras(const types::Recording& recording,
                                  int num_threads,
                                  const base::ProgressCallback& progress) {
    if (camera::has_port(recording.rig()))
        return aligned_behind_ports(recording, num_threads, progress);
    const InParts found = aligned_in_parts(recording, recording.rig(), num_threads, progress);
    const Aligned best =
        may_be_other_medium(found.reference)
            ? in_best_medium(recording, found.reference, found.span, num_threads, progress)
            : found.reference;
    return with_parts(recording, recording.rig(), found, best.alignment, num_threads, progress);
}

}  // namespace divemesh::pipeline
