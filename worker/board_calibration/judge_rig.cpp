#include "worker/board_calibration/judge_rig.hpp"

#include <algorithm>

#include "worker/base/text.hpp"
#include "worker/dive/finding_log.hpp"
#include "worker/stats/distributions.hpp"

namespace divemesh::board_calibration {
namespace {

constexpr double kMaxLengthError = 0.01;  // at 2 m, 95 %: what a dive refines by itself
constexpr double kMinTilt_deg = 20.0;     // below, focal length and distance look alike
constexpr double kMinDistanceRatio = 1.3;
constexpr std::size_t kMinViews = 15;  // views are few when each one decides
constexpr double kMaxNoise_px = 0.6;   // sharp images at rest have 0.05 to 0.3
constexpr double kMaxFlatness = 1e-3;  // of the board's diagonal, largest corner

// Returns the error at 2 m in the worst place, 95 %; nullopt if both cameras see none there.
std::optional<double> error_at_2m(const std::vector<LengthError>& errors) {
    for (const LengthError& error : errors)
        if (error.distance_m == 2.0 && (error.center || error.border))
            return stats::kNormal975 *
                   std::max(error.center.value_or(0.0), error.border.value_or(0.0));
    return std::nullopt;
}

void report_coverage(const ImageCoverage& coverage,
                     const char* camera,
                     dive::FindingLog& findings) {
    for (const std::string& sixth : coverage.empty_sixths())
        findings.warning("board_coverage",
                         camera,
                         "no corner in the " + sixth + " sixth of " + camera,
                         "Hold the board there: lengths that are measured there are extrapolated.");
}

void report_views(const RigEstimate& estimate, dive::FindingLog& findings) {
    for (const ViewLeftOut& view : estimate.left_out)
        findings.warning(
            "board_pair_left_out",
            std::to_string(view.timestamp_ns),
            "this pair harms and is left out: its corners are " + base::fixed(view.rms_px, 2) +
                " px off, those of others " + base::fixed(view.median_rms_px, 2) + " px",
            "Hold the board still, and check that both cameras are triggered together.");
    if (estimate.failure.empty() && estimate.views.size() < kMinViews)
        findings.warning("board_few_pairs",
                         "",
                         "only " + std::to_string(estimate.views.size()) +
                             " pairs are used, so that single ones decide",
                         "Record 20 pairs or more, each with the board in another place.");
}

void report_poses(const ViewCoverage& coverage, dive::FindingLog& findings) {
    if (coverage.tilt_deg.max < kMinTilt_deg)
        findings.warning(
            "board_tilt",
            "",
            "the board was tilted by at most " + base::fixed(coverage.tilt_deg.max, 0) + " degrees",
            "Tilt it by 30 to 45 degrees to all four sides: only that tells the focal "
            "length from the distance.");
    if (coverage.distance_m.max < kMinDistanceRatio * coverage.distance_m.min)
        findings.warning("board_distance",
                         "",
                         "the board was always " + base::fixed(coverage.distance_m.min, 2) +
                             " to " + base::fixed(coverage.distance_m.max, 2) + " m away",
                         "Hold it at the distances at which you survey, near and far.");
}

void report_images(const boards::Board& board,
                   const RigEstimate& estimate,
                   const std::optional<BoardShape>& shape,
                   dive::FindingLog& findings) {
    if (estimate.sigma_px > kMaxNoise_px)
        findings.warning("board_corners_noisy",
                         "",
                         "corners scatter by " + base::fixed(estimate.sigma_px, 2) + " px",
                         "Hold the board still, use short exposures, and try --model with another "
                         "lens model.");
    const double diagonal_m = 2.0 * board.center_m().norm();
    if (shape && shape->flatness_max_m > kMaxFlatness * diagonal_m)
        findings.warning(
            "board_not_flat",
            "",
            "the board looks bent: a corner is " + base::fixed(1e3 * shape->flatness_max_m, 2) +
                " mm off its plane",
            "Use a stiff board: glass, or aluminium composite. If it is flat, the lens "
            "model does not fit.");
}

}  // namespace

RigVerdict judge_rig(const boards::Board& board, const RigEstimate& estimate) {
    RigVerdict verdict;
    dive::FindingLog findings;
    report_views(estimate, findings);
    if (!estimate.failure.empty()) {
        findings.error("calibration_failed", "", estimate.failure, "");
        verdict.text = "not usable: " + estimate.failure;
        verdict.findings = findings.all();
        return verdict;
    }
    verdict.coverage = coverage_of(board, estimate.rig, estimate.views);
    verdict.length_errors = length_errors(estimate.rig, estimate.covariance);
    std::vector<boards::BoardView> views;
    for (const PosedView& posed : estimate.views) views.push_back(posed.view);
    verdict.shape = board_shape(board,
                                estimate.rig.cam0(),
                                estimate.rig.cam1(),
                                isometry_of(estimate.rig.T_cam1_cam0),
                                views);
    report_coverage(verdict.coverage.left, "cam0", findings);
    report_coverage(verdict.coverage.right, "cam1", findings);
    report_poses(verdict.coverage, findings);
    report_images(board, estimate, verdict.shape, findings);
    const auto error = error_at_2m(verdict.length_errors);
    verdict.usable = error && *error <= kMaxLengthError;
    verdict.text = error ? "good to " + base::significant(100.0 * *error, 2) + " % at 2 m"
                         : "no place at 2 m is in both images";
    if (!verdict.usable) {
        findings.error(
            "calibration_uncertain",
            "",
            error ? "lengths at 2 m are uncertain by " + base::significant(100.0 * *error, 2) +
                        " %, more than 1 %"
                  : "no place at 2 m is in both images",
            "Record more pairs, near and far, tilted, and in all corners of both images.");
        verdict.text = "not usable: " + verdict.text;
    }
    verdict.findings = findings.all();
    return verdict;
}

}  // namespace divemesh::board_calibration
