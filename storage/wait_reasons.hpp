#pragma once

#include <cstdint>
#include <set>
#include <soci/soci.h>
#include <string>

#include "schemas/shown_job.hpp"

namespace divemesh::storage {

// What keeps jobs from starting now: pauses, limits, and the state of the workers. A reason is a
// word of WaitReason, or what a worker of a newer version reports; "" means that there is none.
class WaitReasons {
public:
    explicit WaitReasons(soci::session& session);

    // Returns why no job of any project starts.
    const std::string& of_queue() const { return of_queue_; }
    // Returns why a job waits; "" if it only waits for the jobs before it, or does not wait.
    std::string of(const Job& job) const;

    int num_slots() const { return num_slots_; }  // of the workers that take jobs
    std::int64_t now_ms() const { return now_ms_; }

private:
    std::string of_workers(soci::session& session);

    std::int64_t now_ms_;
    std::set<std::string> paused_;
    std::set<std::string> full_;
    int num_slots_ = 0;
    std::string of_queue_;
};

// Returns why a held job waits.
std::string reason_of_held(const Job& job);

// Returns a job with why it waits now, as it is told to those who follow it.
ShownJob with_wait_reason(soci::session& session, const Job& job);

}  // namespace divemesh::storage
