#include "worker/pipeline/alignment_findings.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "worker/base/angle.hpp"
#include "worker/base/seconds.hpp"
#include "worker/base/text.hpp"

namespace divemesh::pipeline {
namespace {

constexpr double kMinShift_px = 0.7;  // findings begin here
// Points found in both images of a pair, below which they show too little that is the same. Where
// they belong together it is 20 to 130.
constexpr double kMinMatchesPerPair = 6.0;
constexpr double kMinFocal = 0.0005;  // change of the focal length in mid-dive that is told
constexpr double kMinTurn_deg = 0.03;
constexpr int kMinPairs = 3;  // of fewer pairs no search says much

std::string degrees(double angle_rad) { return base::fixed(base::kDegPerRad * angle_rad, 2); }

// Returns what the change does to disparities, "" if it is unknown.
std::string disparities_off(const types::RigAlignment& alignment) {
    if (!alignment.moves_disparities()) return "";
    const double bias_px = alignment.disparity_bias_px;
    return ", and all disparities are " + base::fixed(std::abs(bias_px), 1) + " +- " +
           base::fixed(alignment.disparity_bias_sigma_px, 1) + " px too " +
           (bias_px > 0.0 ? "large" : "small") + " (principal point " +
           base::fixed(alignment.change.values[types::RigChange::kCentre], 1) + " px off)";
}

// Returns by how much an image is shifted on its sensor, "" if none is. Rows do not tell whose.
std::string image_shifted(const types::RigChange::Vector& change) {
    const double shift_px = change[types::RigChange::kCentreDown];
    if (shift_px == 0.0) return "";
    const std::string down = shift_px > 0.0 ? "down" : "up";
    const std::string up = shift_px > 0.0 ? "up" : "down";
    return " and its image is shifted " + down + " by " + base::fixed(std::abs(shift_px), 1) +
           " px (or that of the left camera " + up + ")";
}

Finding moved_finding(const types::RigAlignment& alignment) {
    const auto& turned = alignment.change.values;
    return {Severity::Warning,
            "stereo_mismatch",
            "mav0/cam1/sensor.yaml",
            "the right camera is not where the calibration says: it is rotated by " +
                degrees(turned.head<3>().norm()) + " degrees (pitch " + degrees(turned[0]) +
                ", yaw " + degrees(turned[1]) + ", roll " + degrees(turned[2]) + ")" +
                image_shifted(turned) + ", so matching points in the left and right images lie " +
                base::fixed(alignment.row_shift_px, 1) + " px (RMS) off their rows" +
                disparities_off(alignment),
            "The reconstruction estimates this from the images and corrects it unless "
            "align_cameras is off. Calibrate the stereo pair again, and check that the cameras are "
            "fixed tightly."};
}

// The direction of the baseline alone is no knock that is corrected: rows of a scene at one range
// and things that move between the exposures look like it.
Finding rows_off_finding(const types::RigAlignment& alignment) {
    return {Severity::Warning,
            "stereo_mismatch",
            "mav0/cam1/sensor.yaml",
            "matching points in the left and right images lie " +
                base::fixed(alignment.row_shift_px, 1) +
                " px (RMS) off their rows, and no rotation of the right camera explains it: the "
                "baseline points elsewhere than the calibration says, or left and right images "
                "were not taken at the same time",
            "The calibration is used as stated. Calibrate the stereo pair again, and check that "
            "both cameras fire together."};
}

Finding medium_finding(const types::MediumChange& medium) {
    const bool in_air = medium.focal_scale * medium.refractive_index > 1.0;
    const bool is_port = medium.refractive_index != 1.0;
    return {Severity::Warning,
            "calibration_medium",
            "mav0/cam0/sensor.yaml",
            std::string("the cameras were calibrated in ") + (in_air ? "air" : "water") +
                " and record in " + (in_air ? "water" : "air") + ": images of the scene agree " +
                (is_port ? "with the refraction of water at a flat port, which is not described"
                         : "with focal lengths " + base::fixed(medium.focal_scale, 2) +
                               " times those stated"),
            "The reconstruction takes this into account unless align_cameras is off, but a real "
            "port is neither thin nor exactly flat. Describe the port of each camera in its "
            "sensor.yaml, or calibrate the cameras in the medium in which they record."};
}

// Returns how the right camera stands in a part against the part before it, as far as it is known.
std::string moved_by(const types::RigPart& before, const types::RigPart& after) {
    if (!before.found || !after.found) return "too few points are found in both images to tell how";
    const types::RigChange::Vector change = after.values - before.values;
    const bool has_yaw =
        before.sigmas[types::RigChange::kYaw] > 0.0 || after.sigmas[types::RigChange::kYaw] > 0.0;
    std::string text = "the right one turned by " + degrees(change.head<3>().norm()) +
                       " degrees (pitch " + degrees(change[0]) +
                       (has_yaw ? ", yaw " + degrees(change[1]) : "") + ", roll " +
                       degrees(change[2]) + ")";
    if (const double focal = change[types::RigChange::kFocal]; std::abs(focal) >= kMinFocal)
        text += ", its focal length changed by " + base::fixed(100.0 * focal, 1) + " %";
    return text;
}

bool are_alike(const types::RigPart& one, const types::RigPart& other) {
    const types::RigChange::Vector change = other.values - one.values;
    return base::kDegPerRad * change.head<3>().norm() < kMinTurn_deg &&
           std::abs(change[types::RigChange::kFocal]) < kMinFocal;
}

// Adds a warning for each time at which something moved the right camera. Parts that show too
// little to tell how it stands, as in open water, are none if it stands after them as before.
void add_parts(const std::vector<types::RigPart>& parts, std::vector<Finding>& findings) {
    const auto first = std::ranges::find_if(parts, &types::RigPart::found);
    if (first == parts.end()) return;
    auto last = static_cast<std::size_t>(first - parts.begin());
    for (std::size_t i = last + 1; i < parts.size(); ++i) {
        const bool is_last = i + 1 == parts.size();
        if (!parts[i].found && !is_last) continue;
        const bool was_hidden = i > last + 1;
        const std::size_t since = last + 1;
        const types::RigPart& before = parts[std::exchange(last, i)];
        if (was_hidden && parts[i].found && are_alike(before, parts[i])) continue;
        const double since_s = base::to_s(parts[since].from_ns - parts[0].from_ns);
        findings.push_back(
            {Severity::Warning,
             "rig_moved",
             "mav0/cam1/data",
             "after " + base::fixed(since_s, 1) + " s (frame " +
                 std::to_string(parts[since].first_frame) +
                 ") something moved the cameras against each other: " + moved_by(before, parts[i]),
             "The reconstruction corrects what it can tell of this unless align_cameras is off. "
             "Fix the cameras and their focus tightly, and calibrate the stereo pair again before "
             "the next dive."});
    }
}

Finding inconsistent_finding(const types::RigAlignment& alignment) {
    return {Severity::Warning,
            "stereo_inconsistent",
            "mav0/cam1/data",
            "of " + std::to_string(alignment.num_matches) +
                " points found in left and right images, " + std::to_string(alignment.num_inliers) +
                " fit one position of the cameras, and the rows of a pair differ by " +
                base::fixed(alignment.pair_error_px, 1) + " px (RMS) from pair to pair",
            "Check that both cameras expose at the same time, that both images are sharp, that "
            "image stabilisation is off in both cameras, and that they cannot move against each "
            "other."};
}

Finding unmatched_finding(const types::RigAlignment& alignment) {
    return {Severity::Warning,
            "stereo_unmatched",
            "mav0/cam1/data",
            "left and right images show hardly anything that is the same: only " +
                std::to_string(alignment.num_matches) + " points were found in both of " +
                std::to_string(alignment.num_pairs) + " pairs",
            "Check that the images of mav0/cam0 and mav0/cam1 belong together and that their "
            "timestamps are right, that both lenses are clear, and that there is light enough."};
}

// Adds a warning if the solve whose result is the alignment failed or stopped while still moving.
void add_solver(const types::SolverTally& tally,
                const std::string& what,
                std::vector<Finding>& findings) {
    if (tally.num_failed + tally.num_still_moving == 0) return;
    findings.push_back(
        {Severity::Warning,
         "alignment_not_converged",
         "mav0/cam1/sensor.yaml",
         "the estimate of the right camera's position from " + what +
             (tally.num_failed > 0 ? " failed: these are used as stated"
                                   : " had not converged at its limit of iterations"),
         "Calibrate the stereo pair again, or record the scene from more places."});
}

}  // namespace

std::vector<Finding> alignment_findings(const types::RigAlignment& alignment) {
    using Outcome = types::RigAlignment::Outcome;
    std::vector<Finding> findings;
    add_solver(alignment.row_solver, "the rows of the images (pitch, roll, baseline)", findings);
    if (alignment.row_solver.num_failed > 0) return findings;
    add_solver(alignment.range_solver, "ranges of the scene (yaw, principal point)", findings);
    add_parts(alignment.parts, findings);
    if (alignment.outcome == Outcome::Inconsistent) {
        findings.push_back(inconsistent_finding(alignment));
        return findings;
    }
    const bool is_unmatched =
        alignment.num_pairs >= kMinPairs &&
        alignment.num_matches < kMinMatchesPerPair * static_cast<double>(alignment.num_pairs);
    if (alignment.outcome == Outcome::Unknown && is_unmatched)
        findings.push_back(unmatched_finding(alignment));
    if (const auto& medium = alignment.change.medium; !medium.is_none())
        findings.push_back(medium_finding(medium));
    if (alignment.outcome == Outcome::Moved && alignment.shift_px() >= kMinShift_px)
        findings.push_back(moved_finding(alignment));
    if (alignment.outcome == Outcome::AsStated && alignment.row_shift_px >= kMinShift_px)
        findings.push_back(rows_off_finding(alignment));
    return findings;
}

}  // namespace divemesh::pipeline
