#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "schemas/artifact.hpp"
#include "schemas/job.hpp"
#include "schemas/measurement.hpp"
#include "schemas/truth_file.hpp"
#include "storage/catalog.hpp"
#include "storage/dive_store.hpp"
#include "storage/job_inputs.hpp"
#include "storage/page.hpp"

namespace divemesh::storage {

struct JobFilter {
    std::string project;  // "": all projects (admin)
    std::string dive_id;  // "": any
    std::optional<JobState> state;
    std::optional<JobKind> kind;
    bool deleted = false;  // true: only jobs whose result was deleted; false: only the others
    std::int64_t created_after_ms = -1;  // both ends excluded
    std::int64_t created_before_ms = std::numeric_limits<std::int64_t>::max();
};

// A job to be enqueued.
struct NewJob {
    std::string project;
    std::string dive_id;
    JobKind kind = JobKind::Reconstruct;
    std::string preset;
    nlohmann::json options = nlohmann::json::object();
    std::vector<std::string> parents = {};  // jobs of the same project that must succeed first
    int priority = 0;
    int max_attempts = 3;
    // For a report: the reconstruction must be by this version of the program; "": by any.
    std::string fresh_version = {};
    // Key of the request: the same request again finds its job, whatever the job's state. Empty:
    // each request is a new one.
    std::string request_key = {};
};

// A job that was enqueued, or found instead of a new one.
struct EnqueuedJob {
    Job job;
    bool is_new = true;  // false: the same request, or the same work not yet finished
};

// What a user may change of a waiting job.
struct JobChange {
    std::optional<int> priority = std::nullopt;
    std::optional<bool> paused = std::nullopt;
};

// A job that a worker has claimed, with its lease and dive.
struct Claim {
    Job job;
    Lease lease;
    Dive dive;
};

// What a worker learns when it renews its lease.
struct Renewal {
    bool valid = false;  // false: the lease is lost; stop and write nothing more
    bool cancel_requested = false;
};

// What a reconstruction that is not usable has left: its artifacts, findings and verdict.
struct PartialResult {
    std::vector<Artifact> artifacts;
    Measurement measured;
};

// How long a job waits after a failure that may be retried: doubled with each attempt, less up to a
// half at random.
struct RetryPause {
    std::chrono::milliseconds first = std::chrono::seconds(5);
    std::chrono::milliseconds max = std::chrono::minutes(10);
};

// The jobs table with attempts and artifacts. Every change is one transaction with its event. Times
// are those of the catalog's clock. The database itself refuses a change of state that
// kJobTransitions lacks.
class JobStore {
public:
    explicit JobStore(Catalog& catalog, const RetryPause& pause = {})
        : catalog_(catalog), pause_(pause) {}

    // Enqueues a job of its dive's project. It is held until its parents have succeeded, including
    // the intake of its dive. Throws Error{Conflict} for a refused dive and for a parent that did
    // not succeed; Error{NotFound} for a parent of another project. The same work on the same dive
    // is queued once. The dives, jobs and files that a report or a comparison names are looked up
    // and written into its options as ids, see storage/report_jobs.hpp.
    EnqueuedJob enqueue(const NewJob& job);
    Job get(const std::string& id);  // throws Error{NotFound}
    Page<Job> list(const JobFilter& filter, const PageRequest& page);
    std::vector<Attempt> attempts(const std::string& job_id);
    // Returns the artifacts of the attempt that succeeded, or the partial result of a failed job.
    // Throws Error{Gone} if they were deleted.
    std::vector<Artifact> artifacts(const std::string& job_id);
    Artifact artifact(const std::string& job_id, const std::string& name);  // throws NotFound
    std::string log(const std::string& job_id);               // of the newest attempt, truncated
    std::string log(const std::string& job_id, int attempt);  // throws Error{NotFound}

    // Cancels a held or queued job at once; asks the worker of a running one. Throws
    // Error{Conflict} if it is finished.
    Job cancel(const std::string& id);
    // Queues a failed, dead or cancelled job again, with attempts from 0; a deleted result is not
    // restored. Jobs that failed only because of it are held behind it again. Throws
    // Error{Conflict} in another state, on a refused dive, while a parent has not succeeded, and
    // while another job does the same work.
    Job retry(const std::string& id);
    // Throws Error{Conflict} if the job no longer waits.
    Job change(const std::string& id, const JobChange& change);
    // Puts the oldest dead jobs of a project ("": of all) back into the queue, `limit` at most;
    // skips jobs of a deleted or refused dive, and those of projects that store more than
    // `max_project_bytes` (0: no limit). Throws Error{OutOfQuota} if that leaves none.
    std::vector<Job> redrive(const std::string& project,
                             int limit,
                             std::int64_t max_project_bytes = 0);

    // For workers. claim() first frees the jobs of expired leases (storage/job_ends.hpp). Then it
    // takes the first due job by priority and age that no pause, limit or drain holds back.
    std::optional<Claim> claim(const std::string& worker, std::chrono::milliseconds lease);
    Renewal renew(const Lease& lease, std::chrono::milliseconds duration);
    // Returns what a report or a comparison reads besides its dive. Throws Error{Gone} if some of
    // it was deleted.
    JobInputs inputs(const Job& job);
    Renewal check_lease(const Lease& lease);  // the same without renewing: only reads

    // Each write below takes the lease. It returns false, and changes nothing, if the lease is
    // stale.
    bool report_progress(const Lease& lease, const Progress& progress);
    bool report_stage(const Lease& lease, const StageRun& stage);
    bool append_log(const Lease& lease, const std::string& text);
    // Stores artifacts and metrics. A regression among the metrics is an event job.figure_worse.
    bool succeed(const Lease& lease,
                 const std::vector<Artifact>& artifacts,
                 const Measurement& measured = {});
    bool finish_intake(const Lease& lease, const IntakeResult& result);  // dive ready or refused
    // Ends the attempt as storage/job_ends.hpp says. A report whose truth is unreadable, and was
    // not chosen by name, is retried at once with the newest file that is left. If the job fails
    // for good, it keeps the partial result until it is tried again.
    bool fail(const Lease& lease,
              const Failure& failure,
              const std::optional<UnreadableTruth>& unreadable = std::nullopt,
              const PartialResult& partial = {});
    bool release(const Lease& lease);  // graceful shutdown: back to queued, not counted
    // Ends an attempt that failed because of its worker: back to queued after a growing pause, not
    // counted.
    bool return_to_queue(const Lease& lease, const Failure& failure);

    // Does what claim() does first, for times when no worker claims. Returns how many jobs lost
    // their lease.
    int requeue_expired();
    std::vector<std::pair<JobState, std::int64_t>> count_by_state();

private:
    bool with_lease(const Lease& lease,
                    const std::function<void(soci::session&, const Job&)>& write);

    Catalog& catalog_;
    RetryPause pause_;
};

}  // namespace divemesh::storage
