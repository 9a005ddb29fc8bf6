#pragma once

#include <optional>
#include <soci/soci.h>
#include <string>

#include "schemas/job.hpp"

// Read jobs and attempts inside a transaction.
namespace divemesh::storage {

struct JobRow {
    Job job;
    std::string kind;
    std::string state;
    std::string options;
    std::string parents;
    std::string progress;
    std::string stages;
    std::string requirements;
    std::string verdict;
    std::string findings;
    std::string failure_code;
    int paused = 0;
    int lowered = 0;
    int cancel_requested = 0;

    void define(soci::statement& statement);
    Job value() const;
};

inline constexpr const char* kJobColumns =
    "id, project, dive_id, kind, state, preset, options, parents, priority, paused, lowered,"
    " num_attempts, max_attempts, cancel_requested, progress, stages, failure_code,"
    " failure_message, failure_remedy, not_before_ms, created_at_ms, started_at_ms, finished_at_ms,"
    " requirements, verdict, findings";

// A running job whose lease has ended, with what decides its next state.
struct ExpiredJob {
    Job job;
    bool renewed = false;       // its worker renewed the lease after the claim
    int num_silent_losses = 0;  // of the attempts just before this one
};

struct ExpiredRow {
    JobRow row;
    int renewed = 0;
    int num_silent_losses = 0;

    void define(soci::statement& statement);
    ExpiredJob value() const { return {row.value(), renewed != 0, num_silent_losses}; }
};

inline const std::string kExpiredColumns =
    std::string(kJobColumns) + ", lease_renewed, num_silent_losses";

struct AttemptRow {
    Attempt attempt;
    std::string state;
    std::string failure_code;

    void define(soci::statement& statement);
    Attempt value() const;
};

inline constexpr const char* kAttemptColumns =
    "job_id, number, state, worker, failure_code, failure_message, failure_remedy, started_at_ms,"
    " finished_at_ms";

Job read_job(soci::session& session, const std::string& id);  // throws Error{NotFound}

// Returns the job of this lease, locked for the rest of the transaction; nullopt if the lease is
// stale. Every write of a worker begins with it.
std::optional<Job> lock_leased_job(soci::session& session, const Lease& lease);
// Does the same without the lock, for reading.
std::optional<Job> find_leased_job(soci::session& session, const Lease& lease);

}  // namespace divemesh::storage
