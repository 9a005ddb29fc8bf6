#pragma once

#include <cstdint>
#include <optional>
#include <soci/soci.h>
#include <string>

#include "schemas/job.hpp"
#include "storage/job_store.hpp"

// Changes of a job's state inside a transaction: each writes its event and sees to the jobs that
// were waiting for it.
namespace divemesh::storage {

inline constexpr int kIntakePriority = 1000;  // before all others
inline constexpr int kMaxPriority = 100;      // of all others, either way

// Held when the intake of its dive has not succeeded, else queued.
Job insert_job(soci::session& session, const NewJob& request);

void append_job_event(soci::session& session, const std::string& job_id, const std::string& type);

// How an attempt ended and what becomes of its job.
struct AttemptEnd {
    AttemptState attempt = AttemptState::Succeeded;
    JobState job = JobState::Succeeded;
    Failure failure;
    std::int64_t not_before_ms = 0;
    bool counts = true;  // towards max_attempts
};

// Ends the running attempt of `job`. Jobs held behind it follow unless it may still run again.
void end_attempt(soci::session& session, const Job& job, const AttemptEnd& end);

// A job without an attempt: held or queued -> cancelled, held -> failed or queued,
// finished -> queued.
void change_state(soci::session& session,
                  const std::string& job_id,
                  JobState to,
                  const Failure& failure);

// The jobs held behind `parent_id`: without `refusal` they are queued (once they have no other
// parent to wait for), with it they fail.
void settle_children(soci::session& session,
                     const std::string& parent_id,
                     const std::optional<Failure>& refusal);

}  // namespace divemesh::storage
