#pragma once

#include <array>
#include <string_view>

namespace divemesh {

// The life of a job. The only place where its states and transitions are declared;
// api/openapi.yaml and storage/migrations are held to it by tests/architecture.
//
//   held       paused, or its parents are unfinished
//   queued     waits for a worker; `not_before` after a failure that may be retried
//   running    one attempt has the lease
//   succeeded  its artifacts are visible
//   failed     bad data: trying again cannot help
//   dead       the attempts are used up; redrive puts it back into the queue
//   cancelled  by a person; a running job is cancelled once its process is gone
enum class JobState { Held, Queued, Running, Succeeded, Failed, Dead, Cancelled };

inline constexpr auto kJobStates = [] {
    using enum JobState;
    return std::array{Held, Queued, Running, Succeeded, Failed, Dead, Cancelled};
}();

struct JobTransition {
    JobState from;
    JobState to;
};

inline constexpr auto kJobTransitions = [] {
    using enum JobState;
    return std::to_array<JobTransition>({
        {Held, Queued},        // resumed, or the last parent succeeded
        {Held, Failed},        // a parent failed
        {Held, Cancelled},     // by a person
        {Queued, Held},        // paused
        {Queued, Running},     // claimed by a worker
        {Queued, Cancelled},   // by a person, before it started
        {Running, Succeeded},  // artifacts published
        {Running, Failed},     // bad data
        {Running, Queued},     // lost lease, graceful shutdown, or a failure that may be retried
        {Running, Dead},       // attempts used up
        {Running, Cancelled},  // by a person
        {Dead, Queued},        // redrive
        {Failed, Queued},      // asked for again after its cause was mended
        {Failed, Held},        // the parent that it failed with was asked for again
        {Cancelled, Queued},   // asked for again
    });
}();

constexpr bool can_transition(JobState from, JobState to) {
    for (const auto& transition : kJobTransitions)
        if (transition.from == from && transition.to == to) return true;
    return false;
}

// No worker touches a job in such a state, and no time changes it; a person still may.
constexpr bool is_finished(JobState state) {
    return state == JobState::Succeeded || state == JobState::Failed || state == JobState::Dead ||
           state == JobState::Cancelled;
}

std::string_view to_string(JobState state);
JobState job_state_from_string(std::string_view text);  // throws Error{InvalidArgument}

// The life of one attempt: running until it ends in exactly one of the others.
enum class AttemptState { Running, Succeeded, Failed, Cancelled, LeaseLost, Released };

std::string_view to_string(AttemptState state);
AttemptState attempt_state_from_string(std::string_view text);  // throws Error{InvalidArgument}

}  // namespace divemesh
