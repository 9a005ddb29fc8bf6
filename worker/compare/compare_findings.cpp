#include "worker/compare/compare_findings.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "worker/base/text.hpp"
#include "worker/evaluation/tracking_segments.hpp"
#include "worker/stats/distributions.hpp"

namespace divemesh::compare {
namespace {

constexpr double kMaxShareOfInterval = 1.0 / 3.0;  // widens an interval by 5 %

std::string percent(double share) { return base::significant(100.0 * share, 2) + " %"; }

void add_segments(const io::ReconstructionFolder& folder,
                  const char* dive,
                  std::vector<Finding>& findings) {
    const std::vector<types::TrackingSegment> segments = folder.segments();
    if (segments.size() < 2) return;
    std::int64_t num_frames = 0;
    for (const types::TrackingSegment& segment : segments) num_frames += segment.num_frames;
    findings.push_back(
        {Severity::Warning,
         "dive_in_segments",
         dive,
         "the dive is in " + std::to_string(segments.size()) +
             " segments: only what the largest saw, " +
             std::to_string(segments[evaluation::number_of_largest(segments)].num_frames) + " of " +
             std::to_string(num_frames) +
             " frames, is compared, because where the others lie is not known",
         "on the next dive keep the ground in view, and after a pause come back to a place that "
         "was already recorded"});
}

void add_verdict(const io::ReconstructionFolder& folder,
                 const char* dive,
                 std::vector<Finding>& findings) {
    const auto verdict = folder.verdict();
    if (!verdict || *verdict == Verdict::Good) return;
    std::string restricted;
    for (const std::string& part : folder.restrictions())
        restricted += (restricted.empty() ? "" : ", ") + part;
    const bool usable = *verdict == Verdict::UsableWithRestrictions;
    findings.push_back({Severity::Warning,
                        usable ? "dive_restricted" : "dive_not_usable",
                        dive,
                        usable ? "its reconstruction is usable with restrictions: " + restricted
                               : "its reconstruction is not usable, so the change is not either",
                        "see the findings in its report.html"});
}

void add_unknown_vertical(const io::ReconstructionFolder& folder,
                          const char* dive,
                          std::vector<Finding>& findings) {
    if (folder.vertical_is_known()) return;
    findings.push_back({Severity::Warning,
                        "vertical_unknown",
                        dive,
                        "no sensor tells which way is up in this dive, so its ground may lie "
                        "tilted in its model: the two may be aligned in a wrong place, and "
                        "heights, areas and volumes are along z of the earlier dive, which may not "
                        "be upright",
                        "check in the report that both dives show the same ground, and record an "
                        "IMU, an AHRS or a depth sensor on the next dive"});
}

// Compares the scales by the shared ground: with the sigmas that the dives state, and with the
// change that a difference looks like.
void add_scale_difference(const ComparisonResult& result, std::vector<Finding>& findings) {
    const auto& shown = result.registration.scale;
    if (!shown) return;
    const double size = std::abs(shown->value);
    const double allowed =
        stats::kNormal975 * std::hypot(result.a.scale_sigma(), result.b.scale_sigma());
    const double change_m = stats::kNormal975 * size * shown->lever_m;
    if (size <= stats::kNormal975 * shown->sigma ||
        (size <= allowed && change_m <= result.distances.median_lod95_m))
        return;
    findings.push_back(
        {Severity::Warning,
         "scales_differ",
         "",
         "on the shared ground the later dive is " + percent(size) +
             (shown->value > 0.0 ? " larger" : " smaller") +
             " than the earlier one (one standard deviation: " + percent(shown->sigma) +
             "), where their stated scales allow " + percent(allowed) +
             ": this looks like change of up to " + base::fixed(1e3 * change_m, 1) +
             " mm, and the lengths of one of them are wrong",
         "lay a scale bar or two markers of known distance into both dives, and reconstruct them "
         "with correct_scale=auto"});
}

// Volumes grow with the third power of the scale, whose error is in no interval.
void add_scale_sigma(const ComparisonResult& result, std::vector<Finding>& findings) {
    const double sigma = std::max(result.a.scale_sigma(), result.b.scale_sigma());
    const double of_volume = 3.0 * stats::kNormal975 * sigma;
    const auto matters = [&](const stats::Estimate& volume_m3) {
        return of_volume * volume_m3.value >
               kMaxShareOfInterval * (volume_m3.value - volume_m3.low);
    };
    if (!matters(result.changes.grown.volume_m3) && !matters(result.changes.lost.volume_m3)) return;
    findings.push_back({Severity::Warning,
                        "scale_uncertain",
                        "",
                        "the scale of a dive is known to " + percent(sigma) +
                            " (one standard deviation): volumes err by up to another " +
                            percent(of_volume) + ", which their intervals do not contain",
                        "lay a scale bar or two markers of known distance into both dives"});
}

}  // namespace

std::vector<Finding> compare_findings(const ComparisonResult& result) {
    std::vector<Finding> findings;
    for (const auto& [folder, dive] :
         {std::pair{&result.a, "earlier dive"}, std::pair{&result.b, "later dive"}}) {
        add_segments(*folder, dive, findings);
        add_verdict(*folder, dive, findings);
        add_unknown_vertical(*folder, dive, findings);
    }
    add_scale_difference(result, findings);
    add_scale_sigma(result, findings);
    return findings;
}

}  // namespace divemesh::compare
