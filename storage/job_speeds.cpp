#include "storage/job_speeds.hpp"

#include <algorithm>

#include "storage/dive_rows.hpp"
#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

struct SpeedRow {
    std::string kind;
    std::string preset;
    double seconds_per_unit = 0.0;

    void define(soci::statement& statement) {
        define_columns(statement, kind, preset, seconds_per_unit);
    }
    SpeedRow value() const { return *this; }
};

}  // namespace

void learn_speed(soci::session& session, const Job& job) {
    const bool helped = std::any_of(
        job.stages.begin(), job.stages.end(), [](const auto& stage) { return stage.from_cache; });
    const Dive dive = read_dive(session, job.dive_id);
    const std::int64_t num_units =
        job.kind == JobKind::Intake ? dive.archive_bytes : dive.num_frames;
    if (helped || num_units <= 0) return;
    const double seconds = static_cast<double>(std::max<std::int64_t>(
                               0, Catalog::now_ms(session) - job.started_at_ms)) /
                           1000.0;
    const double measured = seconds / static_cast<double>(num_units);
    const std::string kind(to_string(job.kind));
    execute(session,
            "INSERT INTO job_speeds (kind, preset, seconds_per_unit)"
            " VALUES (:kind, :preset, :measured) ON CONFLICT (kind, preset) DO UPDATE SET"
            " seconds_per_unit = 0.75 * job_speeds.seconds_per_unit"
            "   + 0.25 * excluded.seconds_per_unit",
            soci::use(kind, "kind"),
            soci::use(job.preset, "preset"),
            soci::use(measured, "measured"));
}

JobSpeeds read_speeds(soci::session& session) {
    JobSpeeds speeds;
    for (const SpeedRow& row :
         select_all<SpeedRow>(session, "SELECT kind, preset, seconds_per_unit FROM job_speeds"))
        speeds[{row.kind, row.preset}] = row.seconds_per_unit;
    return speeds;
}

}  // namespace divemesh::storage
