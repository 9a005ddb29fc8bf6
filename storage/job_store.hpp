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
    std::int64_t created_after_ms = -1;  // neither of the two included
    std::int64_t created_before_ms = std::numeric_limits<std::int64_t>::max();
};

struct NewJob {
    std::string project;
    std::string dive_id;
    JobKind kind = JobKind::Reconstruct;
    std::string preset;
    nlohmann::json options = nlohmann::json::object();
    std::vector<std::string> parents = {};  // jobs of the same project that have to succeed first
    int priority = 0;
    int max_attempts = 3;
    // Of a report: a reconstruction by this version of the program; "": any will do.
    std::string fresh_version = {};
    // Of the request that asks: when it comes again it finds its job, whatever became of that one.
    // Empty: each time is a request of its own.
    std::string request_key = {};
};

struct EnqueuedJob {
    Job job;
    bool is_new = true;  // false: this request came before, or the same work is still to be done
};

// What a person may change of a job that waits.
struct JobChange {
    std::optional<int> priority = std::nullopt;
    std::optional<bool> paused = std::nullopt;
};

struct Claim {
    Job job;
    Lease lease;
    Dive dive;
};

// What a worker learns when it renews its lease.
struct Renewal {
    bool valid = false;  // false: the lease is lost; stop and write nothing
    bool cancel_requested = false;
};

// How long a job waits after a failure that may be retried: doubled with each attempt, less up to
// a half at random.
struct RetryPause {
    std::chrono::milliseconds first = std::chrono::seconds(5);
    std::chrono::milliseconds longest = std::chrono::minutes(10);
};

// The jobs table with attempts and artifacts. Every change is one transaction with its event.
// Times are the catalog's clock alone. The database itself refuses a change of state that
// kJobTransitions lacks.
class JobStore {
public:
    explicit JobStore(Catalog& catalog, const RetryPause& pause = {})
        : catalog_(catalog), pause_(pause) {}

    // Held until its parents have succeeded, the intake of its dive among them. Error{Conflict} on
    // a refused dive and behind a parent that came to nothing; Error{NotFound} for a parent of
    // another project. Its project is its dive's. The same work on the same dive is queued once.
    // What a report or a comparison names is looked up and written into its options as ids, see
    // storage/report_jobs.hpp.
    EnqueuedJob enqueue(const NewJob& job);
    Job get(const std::string& id);  // throws Error{NotFound}
    Page<Job> list(const JobFilter& filter, const PageRequest& page);
    std::vector<Attempt> attempts(const std::string& job_id);
    std::vector<Artifact> artifacts(const std::string& job_id);  // visible ones: of the success
    Artifact artifact(const std::string& job_id, const std::string& name);  // throws NotFound
    std::string log(const std::string& job_id);               // of the newest attempt, capped
    std::string log(const std::string& job_id, int attempt);  // throws Error{NotFound}

    // For people.
    Job cancel(const std::string& id);  // held, queued: at once; running: asks the worker.
                                        // Error{Conflict} when it is finished
    Job retry(const std::string& id);   // failed, dead, cancelled -> queued, attempts from 0;
                                        // Error{Conflict} otherwise, on a refused dive, and while a
                                        // job it was held behind has not succeeded, and while
                                        // the same work is under way in another job. What
                                        // failed only because of it is held behind it again
    Job change(const std::string& id, const JobChange& change);  // Error{Conflict} when it does
                                                                 // not wait any more
    // Puts the oldest dead jobs of a project ("": of all) back into the queue, `limit` at most;
    // none of a dive that was deleted or refused.
    std::vector<Job> redrive(const std::string& project, int limit);

    // For workers. claim() first frees the jobs of expired leases (storage/job_ends.hpp), then
    // takes the first by priority and age that is due and that no pause, limit or drain keeps back.
    std::optional<Claim> claim(const std::string& worker, std::chrono::milliseconds lease);
    Renewal renew(const Lease& lease, std::chrono::milliseconds duration);
    // What a report or a comparison reads beside its dive. Throws Error{Gone} for what was deleted.
    JobInputs inputs(const Job& job);
    Renewal look(const Lease& lease);  // the same news without renewing: reads alone

    // Every write below carries the lease; false: it is stale and nothing was changed.
    bool report_progress(const Lease& lease, const Progress& progress);
    bool report_stage(const Lease& lease, const StageRun& stage);
    bool append_log(const Lease& lease, const std::string& text);
    // With what it measured; a regression among it is an event job.figure_worse.
    bool succeed(const Lease& lease,
                 const std::vector<Artifact>& artifacts,
                 const Measurement& measured = {});
    bool finish_intake(const Lease& lease, const IntakeResult& result);  // dive ready or refused
    // As storage/job_ends.hpp says. A report whose truth is unreadable, and was not named, is tried
    // again at once with the newest file that is left.
    bool fail(const Lease& lease,
              const Failure& failure,
              const std::optional<UnreadableTruth>& unreadable = std::nullopt);
    bool release(const Lease& lease);  // graceful shutdown: back to queued, not counted

    // What claim() does first, for when no worker claims: how many jobs lost their lease.
    int requeue_expired();
    std::vector<std::pair<JobState, std::int64_t>> count_by_state();

private:
    bool with_lease(const Lease& lease,
                    const std::function<void(soci::session&, const Job&)>& write);

    Catalog& catalog_;
    RetryPause pause_;
};

}  // namespace divemesh::storage
