// What users do to jobs.
#include <deque>
#include <map>
#include <optional>

#include "schemas/error.hpp"
#include "schemas/json.hpp"
#include "storage/dive_rows.hpp"
#include "storage/job_changes.hpp"
#include "storage/job_rows.hpp"
#include "storage/job_store.hpp"
#include "storage/project_usage.hpp"
#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

constexpr int kMaxRedrive = 1000;

[[noreturn]] void throw_wrong_state(const Job& job, const std::string& wanted) {
    throw Error(
        ErrorCode::Conflict,
        "job " + job.id + " is " + std::string(to_string(job.state)) + ": cannot " + wanted);
}

void check_parents_succeeded(soci::session& session, const std::string& job_id) {
    const std::string parent = unfinished_parent(session, job_id);
    if (!parent.empty())
        throw Error(ErrorCode::Conflict,
                    "job " + job_id + " needs job " + parent + " to succeed first: retry that one");
}

std::optional<Job> find_twin_of(soci::session& session, const std::string& job_id) {
    const auto key = select_one<TextRow>(
        session, "SELECT unique_key FROM jobs WHERE id = :id", soci::use(job_id, "id"));
    return find_twin(session, read_job(session, job_id).dive_id, key.value_or(""));
}

void request_cancel(soci::session& session, const std::string& id) {
    execute(session, "UPDATE jobs SET cancel_requested = 1 WHERE id = :id", soci::use(id, "id"));
}

// Returns the children that failed without an attempt, so because of a parent, and whose parents
// may all still succeed.
std::vector<std::string> revivable_children(soci::session& session, const std::string& parent_id) {
    return select_all<TextRow>(
        session,
        "SELECT jobs.id FROM jobs, dives WHERE jobs.state = 'failed' AND jobs.num_attempts = 0"
        " AND jobs.id IN (SELECT job_id FROM job_parents WHERE parent_id = :parent)"
        " AND NOT EXISTS (SELECT 1 FROM job_parents, jobs AS parents"
        "   WHERE job_parents.job_id = jobs.id AND parents.id = job_parents.parent_id"
        "   AND parents.state IN ('failed', 'dead', 'cancelled'))"
        " AND dives.id = jobs.dive_id AND dives.state <> 'refused' AND dives.deleted_at_ms = 0"
        " ORDER BY jobs.created_at_ms, jobs.id",
        soci::use(parent_id, "parent"));
}

// Holds jobs that failed only because of `parent_id` behind it again, generation by generation.
void revive_children(soci::session& session, const std::string& parent_id) {
    std::deque<std::string> revived = {parent_id};
    for (; !revived.empty(); revived.pop_front())
        for (const std::string& child : revivable_children(session, revived.front())) {
            if (find_twin_of(session, child)) continue;
            change_state(session, child, JobState::Held, {});
            revived.push_back(child);
        }
}

// Leaves the blobs of a partial result to remove_leftovers().
void drop_partial_result(soci::session& session, const std::string& id) {
    execute(session, "DELETE FROM artifacts WHERE job_id = :id", soci::use(id, "id"));
    execute(session,
            "UPDATE attempts SET cleaned = 0 WHERE job_id = :id AND state = 'failed'",
            soci::use(id, "id"));
}

// Queues a finished job again, with all its attempts. A deleted result is gone by that.
Job put_back(soci::session& session, const std::string& id) {
    const std::string progress = to_text(Progress{});
    execute(session,
            "UPDATE jobs SET num_attempts = 0, num_silent_losses = 0, cancel_requested = 0,"
            " paused = 0, lowered = 0, deleted_at_ms = 0, expires_at_ms = 0, stages = '[]',"
            " verdict = '', findings = '[]', progress = :progress WHERE id = :id",
            soci::use(progress, "progress"),
            soci::use(id, "id"));
    drop_partial_result(session, id);
    change_state(session, id, JobState::Queued, {});
    revive_children(session, id);
    return read_job(session, id);
}

struct DeadRow {
    std::string id;
    std::string project;

    void define(soci::statement& statement) { define_columns(statement, id, project); }
    DeadRow value() const { return *this; }
};

std::vector<DeadRow> dead_jobs(soci::session& session, const std::string& project) {
    return select_all<DeadRow>(session,
                               "SELECT id, project FROM jobs WHERE state = 'dead'"
                               " AND deleted_at_ms = 0"
                               " AND (:project = '' OR project = :project)"
                               " AND dive_id IN (SELECT id FROM dives WHERE"
                               "   state <> 'refused' AND deleted_at_ms = 0)"
                               " ORDER BY created_at_ms, id",
                               soci::use(project, "project"));
}

// Which projects may have jobs: asked once for each.
class QuotaCheck {
public:
    QuotaCheck(soci::session& session, std::int64_t max_project_bytes)
        : session_(session), max_project_bytes_(max_project_bytes) {}

    bool has_room(const std::string& project) {
        const auto [known, is_new] = has_room_.emplace(project, true);
        if (!is_new) return known->second;
        try {
            require_bytes_of_quota(session_, project, 0, max_project_bytes_);
        } catch (const Error& error) {
            if (error.code() != ErrorCode::OutOfQuota) throw;
            known->second = false;
            if (!refusal_) refusal_ = error;
        }
        return known->second;
    }
    // Throws the first refusal; without one it does nothing.
    void throw_refusal() const {
        if (refusal_) throw Error(*refusal_);
    }

private:
    soci::session& session_;
    std::int64_t max_project_bytes_;
    std::map<std::string, bool> has_room_;
    std::optional<Error> refusal_;
};

void set_priority(soci::session& session, const Job& job, int priority) {
    const std::int64_t rank_ms = queue_rank_ms(job.created_at_ms, priority);
    execute(session,
            "UPDATE jobs SET priority = :priority, queue_rank_ms = :rank WHERE id = :id",
            soci::use(priority, "priority"),
            soci::use(rank_ms, "rank"),
            soci::use(job.id, "id"));
}

void set_paused(soci::session& session, const Job& job, bool paused) {
    const int flag = paused ? 1 : 0;
    execute(session,
            "UPDATE jobs SET paused = :paused WHERE id = :id",
            soci::use(flag, "paused"),
            soci::use(job.id, "id"));
    if (paused && job.state == JobState::Queued)
        return change_state(session, job.id, JobState::Held, {});
    if (!paused && job.state == JobState::Held && unfinished_parent(session, job.id).empty())
        return change_state(session, job.id, JobState::Queued, {});
    append_job_event(session, job.id, "job.changed");
}

}  // namespace

Job JobStore::cancel(const std::string& id) {
    Job job;
    catalog_.transaction([&](soci::session& session) {
        job = read_job(session, id);
        if (is_finished(job.state)) throw_wrong_state(job, "be cancelled");
        if (job.cancel_requested) return;
        request_cancel(session, id);
        if (job.state == JobState::Running)
            append_job_event(session, id, "job.state");
        else
            change_state(session, id, JobState::Cancelled, {ErrorCode::Cancelled, "cancelled"});
        job = read_job(session, id);
    });
    return job;
}

Job JobStore::retry(const std::string& id) {
    Job job;
    catalog_.transaction([&](soci::session& session) {
        job = read_job(session, id);
        if (!is_finished(job.state) || job.state == JobState::Succeeded)
            throw_wrong_state(job, "be tried again");
        require_usable(read_dive(session, job.dive_id));
        check_parents_succeeded(session, id);
        if (const auto twin = find_twin_of(session, id))
            throw Error(ErrorCode::Conflict,
                        "job " + twin->id + " already does the same: use that one");
        job = put_back(session, id);
    });
    return job;
}

// Their parents have succeeded, because a job that still waits for one cannot be dead.
std::vector<Job> JobStore::redrive(const std::string& project,
                                   int limit,
                                   std::int64_t max_project_bytes) {
    if (limit < 1 || limit > kMaxRedrive)
        throw Error(
            ErrorCode::InvalidArgument,
            "limit is " + std::to_string(limit) + ": give 1 to " + std::to_string(kMaxRedrive));
    std::vector<Job> redriven;
    catalog_.transaction([&](soci::session& session) {
        QuotaCheck quota(session, max_project_bytes);
        for (const DeadRow& dead : dead_jobs(session, project)) {
            if (std::ssize(redriven) == limit) break;
            if (!quota.has_room(dead.project) || find_twin_of(session, dead.id)) continue;
            redriven.push_back(put_back(session, dead.id));
        }
        if (redriven.empty()) quota.throw_refusal();
    });
    return redriven;
}

Job JobStore::change(const std::string& id, const JobChange& change) {
    if (change.priority) check_priority(*change.priority);
    Job job;
    catalog_.transaction([&](soci::session& session) {
        job = read_job(session, id);
        if (job.state != JobState::Held && job.state != JobState::Queued)
            throw_wrong_state(job, "be changed: only a waiting job can");
        if (change.priority) set_priority(session, job, *change.priority);
        if (change.paused) set_paused(session, job, *change.paused);
        if (change.priority) append_job_event(session, id, "job.changed");
        job = read_job(session, id);
    });
    return job;
}

}  // namespace divemesh::storage
