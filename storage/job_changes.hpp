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

// Jobs start in the order of this: a step of priority is as good as ten minutes of waiting, so
// nobody waits for ever behind those who are more urgent.
constexpr std::int64_t queue_rank_ms(std::int64_t created_at_ms, int priority) {
    return created_at_ms - std::int64_t{600'000} * priority;
}

// What makes two jobs on a dive the same work: kind, preset and options, less those that change no
// byte of the result.
std::string unique_key(const NewJob& request);

// Throws Error{InvalidArgument} beyond kMaxPriority.
void check_priority(int priority);

// A job that is still to be done and does the same.
std::optional<Job> find_twin(soci::session& session,
                             const std::string& dive_id,
                             const std::string& key);

// JobStore::enqueue in a transaction that does more.
EnqueuedJob enqueue_job(soci::session& session, const NewJob& request);

// Held while a parent or the intake of its dive has not succeeded, else queued.
Job insert_job(soci::session& session, const NewJob& request);

void append_job_event(soci::session& session, const std::string& job_id, const std::string& type);

// How an attempt ended and what becomes of its job.
struct AttemptEnd {
    AttemptState attempt = AttemptState::Succeeded;
    JobState job = JobState::Succeeded;
    Failure failure;
    std::int64_t not_before_ms = 0;
    bool counts = true;    // towards max_attempts
    bool lowered = false;  // from now on the job takes as little memory as it can
    int num_silent_losses = 0;
};

// Ends the running attempt of `job`. Jobs held behind it follow unless it may still run again.
void end_attempt(soci::session& session, const Job& job, const AttemptEnd& end);

// A job without an attempt: held or queued -> cancelled, held -> failed, held <-> queued,
// finished -> queued.
void change_state(soci::session& session,
                  const std::string& job_id,
                  JobState to,
                  const Failure& failure);

// A parent of this job that has not succeeded; "": there is none.
std::string unfinished_parent(soci::session& session, const std::string& job_id);

// The jobs held behind `parent_id`: without `refusal` they are queued (once they have no other
// parent to wait for and are not paused), with it they fail.
void settle_children(soci::session& session,
                     const std::string& parent_id,
                     const std::optional<Failure>& refusal);

}  // namespace divemesh::storage
