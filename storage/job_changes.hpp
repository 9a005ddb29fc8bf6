#pragma once

#include <cstdint>
#include <optional>
#include <soci/soci.h>
#include <string>

#include "schemas/job.hpp"
#include "storage/job_store.hpp"

// Changes of a job's state inside a transaction. Each writes its event and updates the jobs that
// wait for it.
namespace divemesh::storage {

inline constexpr int kIntakePriority = 1000;  // before all other jobs
inline constexpr int kMaxPriority = 100;      // of all other jobs, positive or negative

// Returns the key by which jobs are ordered to start: a step of priority is worth ten minutes of
// waiting, so no job waits for ever behind more urgent ones.
constexpr std::int64_t queue_rank_ms(std::int64_t created_at_ms, int priority) {
    return created_at_ms - std::int64_t{600'000} * priority;
}

// Returns what identifies the same work on a dive: kind, preset and options, except the options
// that change no byte of the result.
std::string unique_key(const NewJob& request);

// Throws Error{InvalidArgument} beyond kMaxPriority.
void check_priority(int priority);

// Returns an unfinished job that does the same work.
std::optional<Job> find_twin(soci::session& session,
                             const std::string& dive_id,
                             const std::string& key);

// Does what JobStore::enqueue does, inside a larger transaction.
EnqueuedJob enqueue_job(soci::session& session, const NewJob& request);

// Inserts a job: held while a parent or the intake of its dive has not succeeded, otherwise queued.
Job insert_job(soci::session& session, const NewJob& request);

void append_job_event(soci::session& session, const std::string& job_id, const std::string& type);

// How an attempt ended and the next state of its job.
struct AttemptEnd {
    AttemptState attempt = AttemptState::Succeeded;
    JobState job = JobState::Succeeded;
    Failure failure;
    std::int64_t not_before_ms = 0;
    bool counts = true;    // towards max_attempts
    bool lowered = false;  // from now on the job uses as little memory as it can
    int num_silent_losses = 0;
};

// Ends the running attempt of `job`. Jobs held behind it follow, unless it may run again.
void end_attempt(soci::session& session, const Job& job, const AttemptEnd& end);

// Changes a job without a running attempt: held or queued -> cancelled, held -> failed, held <->
// queued, finished -> queued.
void change_state(soci::session& session,
                  const std::string& job_id,
                  JobState to,
                  const Failure& failure);

// Returns a parent of this job that has not succeeded; "" if there is none.
std::string unfinished_parent(soci::session& session, const std::string& job_id);

// Settles the jobs held behind `parent_id`. Without `refusal` they are queued, once they wait for
// no other parent and are not paused; with it they fail.
void settle_children(soci::session& session,
                     const std::string& parent_id,
                     const std::optional<Failure>& refusal);

}  // namespace divemesh::storage
