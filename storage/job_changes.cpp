#include "storage/job_changes.hpp"

#include "schemas/error.hpp"
#include "schemas/json.hpp"
#include "storage/event_store.hpp"
#include "storage/ids.hpp"
#include "storage/job_rows.hpp"
#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

std::string code_text(const Failure& failure) {
    return failure.message.empty() ? "" : std::string(to_string(failure.code));
}

// "": there is none, or it has succeeded.
std::string unfinished_intake(soci::session& session, const std::string& dive_id) {
    return select_one<TextRow>(session,
                               "SELECT id FROM jobs WHERE dive_id = :dive AND kind = 'intake'"
                               " AND state <> 'succeeded'",
                               soci::use(dive_id, "dive"))
        .value_or("");
}

void write_end_of_attempt(soci::session& session, const Job& job, const AttemptEnd& end) {
    const std::int64_t now_ms = Catalog::now_ms(session);
    const std::string state(to_string(end.attempt));
    const std::string code = code_text(end.failure);
    execute(session,
            "UPDATE attempts SET state = :state, failure_code = :code, failure_message = :message,"
            " finished_at_ms = :now WHERE job_id = :job AND state = 'running'",
            soci::use(state, "state"),
            soci::use(code, "code"),
            soci::use(end.failure.message, "message"),
            soci::use(now_ms, "now"),
            soci::use(job.id, "job"));
}

void write_job_after_attempt(soci::session& session, const Job& job, const AttemptEnd& end) {
    const std::string state(to_string(end.job));
    const std::string code = code_text(end.failure);
    const std::int64_t finished_at_ms = is_finished(end.job) ? Catalog::now_ms(session) : 0;
    const int num_attempts = job.num_attempts - (end.counts ? 0 : 1);
    Progress progress = end.job == JobState::Queued ? Progress{} : job.progress;
    if (end.job == JobState::Succeeded) progress.fraction = 1.0, progress.seconds_left = 0.0;
    const std::string progress_text = to_text(progress);
    execute(session,
            "UPDATE jobs SET state = :state, lease_id = NULL, lease_expires_at_ms = NULL,"
            " num_attempts = :attempts, progress = :progress, failure_code = :code,"
            " failure_message = :message, not_before_ms = :not_before,"
            " finished_at_ms = :finished WHERE id = :id",
            soci::use(state, "state"),
            soci::use(num_attempts, "attempts"),
            soci::use(progress_text, "progress"),
            soci::use(code, "code"),
            soci::use(end.failure.message, "message"),
            soci::use(end.not_before_ms, "not_before"),
            soci::use(finished_at_ms, "finished"),
            soci::use(job.id, "id"));
}

// What the jobs behind one that came to nothing are told.
std::optional<Failure> refusal_from(const std::string& parent_id,
                                    JobState state,
                                    const Failure& failure) {
    if (state == JobState::Succeeded) return std::nullopt;
    std::string message =
        "job " + parent_id + ", which this one waited for, is " + std::string(to_string(state));
    if (!failure.message.empty()) message += ": " + failure.message;
    return Failure{.code = state == JobState::Failed ? failure.code : ErrorCode::Conflict,
                   .message = message};
}

}  // namespace

Job insert_job(soci::session& session, const NewJob& request) {
    Job job{.id = new_id("job"),
            .project = request.project,
            .dive_id = request.dive_id,
            .kind = request.kind,
            .preset = request.preset,
            .options = request.options,
            .priority = request.priority,
            .max_attempts = request.max_attempts};
    const std::string parent =
        job.kind == JobKind::Intake ? "" : unfinished_intake(session, job.dive_id);
    job.state = parent.empty() ? JobState::Queued : JobState::Held;
    job.created_at_ms = Catalog::now_ms(session);
    const std::string kind(to_string(job.kind));
    const std::string state(to_string(job.state));
    const std::string options = to_text(job.options);
    const std::string progress = to_text(job.progress);
    execute(session,
            "INSERT INTO jobs (id, project, dive_id, kind, state, preset, options, priority,"
            " max_attempts, progress, created_at_ms) VALUES (:id, :project, :dive, :kind, :state,"
            " :preset, :options, :priority, :max_attempts, :progress, :now)",
            soci::use(job.id, "id"),
            soci::use(job.project, "project"),
            soci::use(job.dive_id, "dive"),
            soci::use(kind, "kind"),
            soci::use(state, "state"),
            soci::use(job.preset, "preset"),
            soci::use(options, "options"),
            soci::use(job.priority, "priority"),
            soci::use(job.max_attempts, "max_attempts"),
            soci::use(progress, "progress"),
            soci::use(job.created_at_ms, "now"));
    if (!parent.empty())
        execute(session,
                "INSERT INTO job_parents (job_id, parent_id) VALUES (:job, :parent)",
                soci::use(job.id, "job"),
                soci::use(parent, "parent"));
    append_job_event(session, job.id, "job.state");
    return job;
}

void append_job_event(soci::session& session, const std::string& job_id, const std::string& type) {
    const Job job = read_job(session, job_id);
    const Event event{
        .project = job.project, .topic = "job", .subject = job.id, .type = type, .data = job};
    if (type == "job.progress") return EventStore::replace(session, event);
    EventStore::append(session, event);
}

void end_attempt(soci::session& session, const Job& job, const AttemptEnd& end) {
    write_end_of_attempt(session, job, end);
    write_job_after_attempt(session, job, end);
    append_job_event(session, job.id, "job.state");
    // Of an intake, the dive decides: finish_intake settles those.
    if (is_finished(end.job) && end.job != JobState::Succeeded)
        settle_children(session, job.id, refusal_from(job.id, end.job, end.failure));
    else if (end.job == JobState::Succeeded && job.kind != JobKind::Intake)
        settle_children(session, job.id, std::nullopt);
}

void change_state(soci::session& session,
                  const std::string& job_id,
                  JobState to,
                  const Failure& failure) {
    const std::string state(to_string(to));
    const std::string code = code_text(failure);
    const std::int64_t finished_at_ms = is_finished(to) ? Catalog::now_ms(session) : 0;
    execute(session,
            "UPDATE jobs SET state = :state, failure_code = :code, failure_message = :message,"
            " not_before_ms = 0, finished_at_ms = :finished WHERE id = :id",
            soci::use(state, "state"),
            soci::use(code, "code"),
            soci::use(failure.message, "message"),
            soci::use(finished_at_ms, "finished"),
            soci::use(job_id, "id"));
    append_job_event(session, job_id, "job.state");
    if (is_finished(to)) settle_children(session, job_id, refusal_from(job_id, to, failure));
}

void settle_children(soci::session& session,
                     const std::string& parent_id,
                     const std::optional<Failure>& refusal) {
    const auto children = select_all<TextRow>(
        session,
        "SELECT id FROM jobs WHERE state = 'held'"
        " AND id IN (SELECT job_id FROM job_parents WHERE parent_id = :parent)"
        " AND (:refused = 1 OR NOT EXISTS (SELECT 1 FROM job_parents, jobs AS parents"
        "   WHERE job_parents.job_id = jobs.id AND parents.id = job_parents.parent_id"
        "   AND parents.state <> 'succeeded'))"
        " ORDER BY created_at_ms, id",
        soci::use(parent_id, "parent"),
        soci::use(refusal ? 1 : 0, "refused"));
    for (const std::string& child : children)
        change_state(session,
                     child,
                     refusal ? JobState::Failed : JobState::Queued,
                     refusal.value_or(Failure{}));
}

}  // namespace divemesh::storage
