#include "storage/job_rows.hpp"

#include "schemas/error.hpp"
#include "schemas/json.hpp"
#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

const std::string kLeased =
    " WHERE id = :id AND attempt = :attempt AND lease_id = :lease AND state = 'running'";

// Without a failure no code is stored.
ErrorCode failure_code_from(const std::string& text) {
    return text.empty() ? Failure{}.code : error_code_from_string(text);
}

}  // namespace

void JobRow::define(soci::statement& statement) {
    define_columns(statement,
                   job.id,
                   job.project,
                   job.dive_id,
                   kind,
                   state,
                   job.preset,
                   options,
                   parents,
                   job.priority,
                   paused,
                   lowered,
                   job.num_attempts,
                   job.max_attempts,
                   cancel_requested,
                   progress,
                   stages,
                   failure_code,
                   job.failure.message,
                   job.failure.remedy,
                   job.not_before_ms,
                   job.created_at_ms,
                   job.started_at_ms,
                   job.finished_at_ms,
                   requirements,
                   verdict,
                   findings);
}

Job JobRow::value() const {
    Job value = job;
    value.kind = job_kind_from_string(kind);
    value.state = job_state_from_string(state);
    value.options = nlohmann::json::parse(options);
    value.parents = nlohmann::json::parse(parents).get<std::vector<std::string>>();
    value.paused = paused != 0;
    value.lowered = lowered != 0;
    value.progress = nlohmann::json::parse(progress).get<Progress>();
    value.stages = nlohmann::json::parse(stages).get<std::vector<StageRun>>();
    value.requirements = nlohmann::json::parse(requirements).get<std::vector<RequirementResult>>();
    if (!verdict.empty()) value.verdict = verdict_from_string(verdict);
    value.findings = nlohmann::json::parse(findings).get<std::vector<Finding>>();
    value.failure.code = failure_code_from(failure_code);
    value.cancel_requested = cancel_requested != 0;
    return value;
}

void ExpiredRow::define(soci::statement& statement) {
    row.define(statement);
    define_columns(statement, renewed, num_silent_losses);
}

void AttemptRow::define(soci::statement& statement) {
    define_columns(statement,
                   attempt.job_id,
                   attempt.number,
                   state,
                   attempt.worker,
                   failure_code,
                   attempt.failure.message,
                   attempt.failure.remedy,
                   attempt.started_at_ms,
                   attempt.finished_at_ms);
}

Attempt AttemptRow::value() const {
    Attempt value = attempt;
    value.state = attempt_state_from_string(state);
    value.failure.code = failure_code_from(failure_code);
    return value;
}

Job read_job(soci::session& session, const std::string& id) {
    static const std::string kById =
        "SELECT " + std::string(kJobColumns) + " FROM jobs WHERE id = :id";
    auto job = select_prepared<JobRow>(session, kById, id);
    if (!job) throw Error(ErrorCode::NotFound, "no job " + id);
    return std::move(*job);
}

std::optional<Job> lock_leased_job(soci::session& session, const Lease& lease) {
    return select_one<JobRow>(
        session,
        "UPDATE jobs SET lease_id = lease_id" + kLeased + " RETURNING " + kJobColumns,
        soci::use(lease.job_id, "id"),
        soci::use(lease.attempt, "attempt"),
        soci::use(lease.lease_id, "lease"));
}

std::optional<Job> find_leased_job(soci::session& session, const Lease& lease) {
    return select_one<JobRow>(session,
                              "SELECT " + std::string(kJobColumns) + " FROM jobs" + kLeased,
                              soci::use(lease.job_id, "id"),
                              soci::use(lease.attempt, "attempt"),
                              soci::use(lease.lease_id, "lease"));
}

}  // namespace divemesh::storage
