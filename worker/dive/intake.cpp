#include "worker/dive/intake.hpp"

#include <memory>

#include "worker/dive/entry_name.hpp"
#include "worker/dive/image_survey.hpp"
#include "worker/dive/refusal.hpp"
#include "worker/dive/stored_dive.hpp"

namespace divemesh::dive {
namespace {

// Returns a callback for a part of the work, so that the fraction rises from 0 to 1 over all parts.
base::ProgressCallback part(const base::ProgressCallback& progress, double begin, double share) {
    return [&progress, begin, share](const Progress& state) {
        Progress whole = state;
        whole.stage = "check";
        whole.fraction = begin + share * state.fraction;
        progress(whole);
    };
}

void report_images(StoredDive& dive, IntakeReport& report, const base::ProgressCallback& progress) {
    const ImageSurvey survey = survey_images(dive, progress);
    survey.report(dive.rig().cam0.width_px > 0 ? dive.num_frames() : 0, dive.log());
    if (const auto middle = survey.middle_frame())
        report.thumbnail_jpeg = thumbnail_jpeg(dive.left_in_color(*middle, 1));
    if (dive.num_skipped_frames() > 0)
        dive.log().warning("frames_skipped",
                           "",
                           std::to_string(dive.num_skipped_frames()) + " of " +
                               std::to_string(dive.num_frames()) + " frames are skipped",
                           "The findings about images say why. Copy unreadable ones from the "
                           "recorder again; if there are many, check its card.");
}

void examine(StoredDive& dive,
             IntakeReport& report,
             const base::ProgressCallback& progress,
             const RecordingCheck& check) {
    report.name = dive.info().name;
    report.site = dive.info().site;
    report.rig = dive.info().rig;
    report.tags = dive.info().tags;
    report.notes = dive.info().notes;
    report.position = dive.info().position;
    report.num_frames = dive.num_frames();
    report.duration_s = dive.duration_s();
    dive.hash_contents(part(progress, 0.3, 0.1));
    report.content_sha256 = dive.content_hash();
    report_images(dive, report, part(progress, 0.4, 0.55));
    report.findings = dive.findings();
    if (!check || has_error(report.findings)) return;
    const auto checked = check(dive, part(progress, 0.95, 0.05));
    report.findings.insert(report.findings.end(), checked.begin(), checked.end());
}

}  // namespace

IntakeReport examine_dive(const std::filesystem::path& path,
                          const std::filesystem::path& scratch,
                          const base::ProgressCallback& progress,
                          const RecordingCheck& check,
                          Links links) {
    IntakeReport report;
    try {
        const auto opening = part(progress, 0.0, 0.3);
        StoredDive dive(path, scratch, {}, opening, links);
        examine(dive, report, progress, check);
    } catch (const Refusal& refusal) {
        report.findings.push_back(refusal.finding());
    }
    return report;
}

}  // namespace divemesh::dive
