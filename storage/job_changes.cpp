#include "storage/job_changes.hpp"

#include <algorithm>
#include <deque>

#include "schemas/content_hash.hpp"
#include "schemas/error.hpp"
#include "schemas/json.hpp"
#include "storage/event_store.hpp"
#include "storage/ids.hpp"
#include "storage/job_rows.hpp"
#include "storage/sql.hpp"
#include "storage/wait_reasons.hpp"

namespace divemesh::storage {
namespace {

// A failure as stored, with a remedy; all fields are empty without a failure.
struct FailureText {
    explicit FailureText(const Failure& failure) : message(failure.message) {
        if (message.empty()) return;
        code = to_string(failure.code);
        remedy = failure.remedy.empty() ? usual_remedy(failure.code) : failure.remedy;
    }
    std::string code;
    std::string message;
    std::string remedy;
};

// Returns the dive's intake job that has not succeeded; "" if there is none.
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
    const FailureText failure(end.failure);
    execute(session,
            "UPDATE attempts SET state = :state, failure_code = :code, failure_message = :message,"
            " failure_remedy = :remedy, finished_at_ms = :now WHERE job_id = :job AND state = "
            "'running'",
            soci::use(state, "state"),
            soci::use(failure.code, "code"),
            soci::use(failure.message, "message"),
            soci::use(failure.remedy, "remedy"),
            soci::use(now_ms, "now"),
            soci::use(job.id, "job"));
}

void write_job_after_attempt(soci::session& session, const Job& job, const AttemptEnd& end) {
    const std::string state(to_string(end.job));
    const FailureText failure(end.failure);
    const std::int64_t finished_at_ms = is_finished(end.job) ? Catalog::now_ms(session) : 0;
    const int num_attempts = job.num_attempts - (end.counts ? 0 : 1);
    const int lowered = job.lowered || end.lowered ? 1 : 0;
    Progress progress = end.job == JobState::Queued ? Progress{} : job.progress;
    if (end.job == JobState::Succeeded) progress.fraction = 1.0, progress.seconds_left = 0.0;
    const std::string progress_text = to_text(progress);
    execute(session,
            "UPDATE jobs SET state = :state, lease_id = NULL, lease_expires_at_ms = NULL,"
            " lease_renewed = 0, num_silent_losses = :losses, lowered = :lowered,"
            " num_attempts = :attempts, progress = :progress, failure_code = :code,"
            " failure_message = :message, failure_remedy = :remedy, not_before_ms = :not_before,"
            " finished_at_ms = :finished WHERE id = :id",
            soci::use(state, "state"),
            soci::use(end.num_silent_losses, "losses"),
            soci::use(lowered, "lowered"),
            soci::use(num_attempts, "attempts"),
            soci::use(progress_text, "progress"),
            soci::use(failure.code, "code"),
            soci::use(failure.message, "message"),
            soci::use(failure.remedy, "remedy"),
            soci::use(end.not_before_ms, "not_before"),
            soci::use(finished_at_ms, "finished"),
            soci::use(job.id, "id"));
}

// Returns the failure for the jobs behind a job that did not succeed; nullopt if they may run.
std::optional<Failure> refusal_from(const std::string& parent_id,
                                    JobState state,
                                    const Failure& failure) {
    if (state == JobState::Succeeded) return std::nullopt;
    std::string message =
        "job " + parent_id + ", which this one waited for, is " + std::string(to_string(state));
    if (!failure.message.empty()) message += ": " + failure.message;
    return Failure{.code = state == JobState::Failed ? failure.code : ErrorCode::Conflict,
                   .message = message,
                   .remedy = "retry job " + parent_id + ": this one then waits for it again"};
}

// Returns the requested parents, and the intake of the dive while it has not succeeded.
std::vector<std::string> all_parents(soci::session& session, const NewJob& request) {
    std::vector<std::string> parents = request.parents;
    const std::string intake =
        request.kind == JobKind::Intake ? "" : unfinished_intake(session, request.dive_id);
    if (!intake.empty()) parents.push_back(intake);
    std::sort(parents.begin(), parents.end());
    parents.erase(std::unique(parents.begin(), parents.end()), parents.end());
    return parents;
}

void write_new_job(soci::session& session, const Job& job, const std::string& key) {
    const std::string kind(to_string(job.kind));
    const std::string state(to_string(job.state));
    const std::string options = to_text(job.options);
    const std::string parents = to_text(job.parents);
    const std::string progress = to_text(job.progress);
    const std::int64_t rank_ms = queue_rank_ms(job.created_at_ms, job.priority);
    execute(session,
            "INSERT INTO jobs (id, project, dive_id, kind, state, preset, options, parents,"
            " priority, queue_rank_ms, unique_key, max_attempts, progress, created_at_ms)"
            " VALUES (:id, :project, :dive, :kind, :state, :preset, :options, :parents,"
            " :priority, :rank, :key, :max_attempts, :progress, :now)",
            soci::use(job.id, "id"),
            soci::use(job.project, "project"),
            soci::use(job.dive_id, "dive"),
            soci::use(kind, "kind"),
            soci::use(state, "state"),
            soci::use(job.preset, "preset"),
            soci::use(options, "options"),
            soci::use(parents, "parents"),
            soci::use(job.priority, "priority"),
            soci::use(rank_ms, "rank"),
            soci::use(key, "key"),
            soci::use(job.max_attempts, "max_attempts"),
            soci::use(progress, "progress"),
            soci::use(job.created_at_ms, "now"));
}

void write_state(soci::session& session,
                 const std::string& job_id,
                 JobState to,
                 const Failure& failure) {
    const std::string state(to_string(to));
    const FailureText text(failure);
    const std::int64_t finished_at_ms = is_finished(to) ? Catalog::now_ms(session) : 0;
    execute(
        session,
        "UPDATE jobs SET state = :state, failure_code = :code, failure_message = :message,"
        " failure_remedy = :remedy, not_before_ms = 0, finished_at_ms = :finished WHERE id = :id",
        soci::use(state, "state"),
        soci::use(text.code, "code"),
        soci::use(text.message, "message"),
        soci::use(text.remedy, "remedy"),
        soci::use(finished_at_ms, "finished"),
        soci::use(job_id, "id"));
    append_job_event(session, job_id, "job.state");
}

std::vector<std::string> held_children(soci::session& session, const std::string& parent_id) {
    return select_all<TextRow>(
        session,
        "SELECT id FROM jobs WHERE state = 'held'"
        " AND id IN (SELECT job_id FROM job_parents WHERE parent_id = :parent)"
        " ORDER BY created_at_ms, id",
        soci::use(parent_id, "parent"));
}

// Returns the children that wait for no other parent and are not paused.
std::vector<std::string> released_children(soci::session& session, const std::string& parent_id) {
    return select_all<TextRow>(
        session,
        "SELECT id FROM jobs WHERE state = 'held' AND paused = 0"
        " AND id IN (SELECT job_id FROM job_parents WHERE parent_id = :parent)"
        " AND NOT EXISTS (SELECT 1 FROM job_parents, jobs AS parents"
        "   WHERE job_parents.job_id = jobs.id AND parents.id = job_parents.parent_id"
        "   AND parents.state <> 'succeeded')"
        " ORDER BY created_at_ms, id",
        soci::use(parent_id, "parent"));
}

}  // namespace

std::string unique_key(const NewJob& request) {
    nlohmann::json options = request.options;
    for (const char* name : {"num_threads", "fusion_memory_bytes", "newest"}) options.erase(name);
    return sha256_hex(std::string(to_string(request.kind)) + "\n" + request.preset + "\n" +
                      to_text(options));
}

void check_priority(int priority) {
    if (priority < -kMaxPriority || priority > kMaxPriority)
        throw Error(ErrorCode::InvalidArgument,
                    "priority is " + std::to_string(priority) + ": give -" +
                        std::to_string(kMaxPriority) + " to " + std::to_string(kMaxPriority));
}

std::optional<Job> find_twin(soci::session& session,
                             const std::string& dive_id,
                             const std::string& key) {
    return select_one<JobRow>(session,
                              "SELECT " + std::string(kJobColumns) +
                                  " FROM jobs WHERE dive_id = :dive AND unique_key = :key"
                                  " AND state IN ('held', 'queued', 'running')",
                              soci::use(dive_id, "dive"),
                              soci::use(key, "key"));
}

std::string unfinished_parent(soci::session& session, const std::string& job_id) {
    return select_one<TextRow>(
               session,
               "SELECT jobs.id FROM jobs, job_parents"
               " WHERE job_parents.job_id = :job AND jobs.id = job_parents.parent_id"
               " AND jobs.state <> 'succeeded' ORDER BY jobs.id LIMIT 1",
               soci::use(job_id, "job"))
        .value_or("");
}

Job insert_job(soci::session& session, const NewJob& request) {
    Job job{.id = new_id("job"),
            .project = request.project,
            .dive_id = request.dive_id,
            .kind = request.kind,
            .preset = request.preset,
            .options = request.options,
            .parents = all_parents(session, request),
            .priority = request.priority,
            .max_attempts = request.max_attempts,
            .created_at_ms = Catalog::now_ms(session)};
    const bool waits = std::any_of(job.parents.begin(), job.parents.end(), [&](const auto& id) {
        return read_job(session, id).state != JobState::Succeeded;
    });
    job.state = waits ? JobState::Held : JobState::Queued;
    write_new_job(session, job, unique_key(request));
    for (const std::string& parent : job.parents)
        execute(session,
                "INSERT INTO job_parents (job_id, parent_id) VALUES (:job, :parent)",
                soci::use(job.id, "job"),
                soci::use(parent, "parent"));
    append_job_event(session, job.id, "job.state");
    return job;
}

void append_job_event(soci::session& session, const std::string& job_id, const std::string& type) {
    const Job job = read_job(session, job_id);
    const Event event{.project = job.project,
                      .topic = "job",
                      .subject = job.id,
                      .type = type,
                      .data = with_wait_reason(session, job)};
    if (type == "job.progress") return EventStore::replace(session, event);
    EventStore::append(session, event);
}

void end_attempt(soci::session& session, const Job& job, const AttemptEnd& end) {
    write_end_of_attempt(session, job, end);
    write_job_after_attempt(session, job, end);
    append_job_event(session, job.id, "job.state");
    // The dive decides after an intake: finish_intake settles its children.
    if (is_finished(end.job) && end.job != JobState::Succeeded)
        settle_children(session, job.id, refusal_from(job.id, end.job, end.failure));
    else if (end.job == JobState::Succeeded && job.kind != JobKind::Intake)
        settle_children(session, job.id, std::nullopt);
}

void change_state(soci::session& session,
                  const std::string& job_id,
                  JobState to,
                  const Failure& failure) {
    write_state(session, job_id, to, failure);
    if (is_finished(to)) settle_children(session, job_id, refusal_from(job_id, to, failure));
}

// Goes generation by generation, not by recursion, because a user may have made a chain of any
// length.
void settle_children(soci::session& session,
                     const std::string& parent_id,
                     const std::optional<Failure>& refusal) {
    if (!refusal) {
        for (const std::string& child : released_children(session, parent_id))
            write_state(session, child, JobState::Queued, {});
        return;
    }
    std::deque<std::pair<std::string, Failure>> refused = {{parent_id, *refusal}};
    for (; !refused.empty(); refused.pop_front()) {
        const auto& [parent, failure] = refused.front();
        for (const std::string& child : held_children(session, parent)) {
            write_state(session, child, JobState::Failed, failure);
            refused.emplace_back(child, failure);
        }
    }
}

}  // namespace divemesh::storage
