#include "storage/job_inputs.hpp"

#include "schemas/error.hpp"
#include "storage/dive_rows.hpp"
#include "storage/job_rows.hpp"
#include "storage/job_store.hpp"
#include "storage/metric_store.hpp"
#include "storage/report_jobs.hpp"
#include "storage/sql.hpp"
#include "storage/truth_store.hpp"

namespace divemesh::storage {
namespace {

[[noreturn]] void refuse(const std::string& what, const std::string& remedy) {
    throw Error(ErrorCode::Gone, what + ": " + remedy);
}

struct SourceRow {
    std::string dive_id;
    std::int64_t deleted_at_ms = 0;

    void define(soci::statement& statement) { define_columns(statement, dive_id, deleted_at_ms); }
    std::pair<std::string, std::int64_t> value() const { return {dive_id, deleted_at_ms}; }
};

void require_there(soci::session& session, const std::string& job_id) {
    const auto source = select_one<SourceRow>(
        session,
        "SELECT dives.id, dives.deleted_at_ms FROM jobs JOIN dives ON dives.id = dive_id"
        " WHERE jobs.id = :id",
        soci::use(job_id, "id"));
    if (!source)
        refuse("reconstruction " + job_id + " was removed with its dive",
               "create a new report or comparison");
    if (source->second > 0)
        refuse("dive " + source->first + ", of reconstruction " + job_id + ", was deleted",
               "restore it, then retry this job");
}

TruthFile read_named_truth(soci::session& session,
                           const std::string& dive_id,
                           const std::string& id) {
    auto file = find_truth(session, id);
    if (!file || file->dive_id != dive_id)
        refuse("truth " + id + " was deleted", "upload it again and create a new report");
    return std::move(*file);
}

}  // namespace

JobInputs JobStore::inputs(const Job& job) {
    JobInputs inputs;
    std::vector<std::string> sources;
    for (const char* name : {"job", "with"})
        if (job.options.contains(name)) sources.push_back(job.options[name].get<std::string>());
    catalog_.read([&](soci::session& session) {
        for (const std::string& source : sources) require_there(session, source);
        for (const TruthKind kind : kTruthKinds) {
            const auto id = job.options.find(std::string(to_string(kind)));
            if (id != job.options.end() && *id != kTruthOfDive)
                inputs.truth[id.key()] =
                    read_named_truth(session, job.dive_id, id->get<std::string>());
        }
        if (const auto id = job.options.find(kLaterAreas); id != job.options.end())
            inputs.truth[kLaterAreas] = read_named_truth(
                session, read_job(session, sources.back()).dive_id, id->get<std::string>());
        if (job.kind != JobKind::AccuracyReport) return;
        inputs.set_aside = truth_set_aside(session, job);
        inputs.history = earlier_metrics(session,
                                         {.project = job.project,
                                          .dive_id = job.dive_id,
                                          .tag = job.options.value("tag", ""),
                                          .preset = job.preset,
                                          .measured_job_id = job.options.value("job", "")});
    });
    for (const std::string& source : sources) inputs.reconstructions.push_back(artifacts(source));
    return inputs;
}

}  // namespace divemesh::storage
