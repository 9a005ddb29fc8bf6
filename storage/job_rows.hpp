#pragma once

#include <optional>
#include <soci/soci.h>
#include <string>

#include "schemas/job.hpp"

// Reads of jobs and attempts inside a transaction.
namespace divemesh::storage {

struct JobRow {
    Job job;
    std::string kind;
    std::string state;
    std::string options;
    std::string progress;
    std::string failure_code;
    int cancel_requested = 0;

    void define(soci::statement& statement);
    Job value() const;
};

inline constexpr const char* kJobColumns =
    "id, project, dive_id, kind, state, preset, options, priority, num_attempts, max_attempts,"
    " cancel_requested, progress, failure_code, failure_message, not_before_ms, created_at_ms,"
    " started_at_ms, finished_at_ms";

struct AttemptRow {
    Attempt attempt;
    std::string state;
    std::string failure_code;

    void define(soci::statement& statement);
    Attempt value() const;
};

inline constexpr const char* kAttemptColumns =
    "job_id, number, state, worker, failure_code, failure_message, started_at_ms, finished_at_ms";

Job read_job(soci::session& session, const std::string& id);  // throws Error{NotFound}

// The job that this lease holds, locked for the rest of the transaction; nothing when the lease is
// stale. Every write of a worker begins with it.
std::optional<Job> lock_leased_job(soci::session& session, const Lease& lease);
// The same without the lock, for reading.
std::optional<Job> find_leased_job(soci::session& session, const Lease& lease);

}  // namespace divemesh::storage
