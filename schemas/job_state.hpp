#pragma once

#include <array>
#include <string_view>

namespace divemesh {

// The life of a job: the only place that declares its states and transitions. tests/architecture
// compares api/openapi.yaml and storage/migrations with it.
//
//   held       paused, or its parents are unfinished
//   queued     waits for a worker; `not_before` after a failure that may be retried
//   running    one attempt has the lease
//   succeeded  its artifacts are visible
//   failed     bad data: a retry cannot help
//   dead       the attempts are used up; redrive puts it back into the queue
//   cancelled  by a user; a running job is cancelled once its process is gone
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
        {Held, Failed},        // a parent did not succeed
        {Held, Cancelled},     // by a user
        {Queued, Held},        // paused
        {Queued, Running},     // claimed by a worker
        {Queued, Cancelled},   // by a user, before it started
        {Running, Succeeded},  // artifacts published
        {Running, Failed},     // bad data
        {Running, Queued},     // lost lease, graceful shutdown, or a failure that may be retried
        {Running, Dead},       // attempts used up
        {Running, Cancelled},  // by a user
        {Dead, Queued},        // redrive
        {Failed, Queued},      // retried after its cause was fixed
        {Failed, Held},        // retried together with the parent that it failed with
        {Cancelled, Queued},   // retried
    });
}();

constexpr bool can_transition(JobState from, JobState to) {
    for (const auto& transition : kJobTransitions)
        if (transition.from == from && transition.to == to) return true;
    return false;
}

// Returns whether a state is final: no worker and no time changes it; a user still may.
constexpr bool is_finished(JobState state) {
    return state == JobState::Succeeded || state == JobState::Failed || state == JobState::Dead ||
           state == JobState::Cancelled;
}

std::string_view to_string(JobState state);
JobState job_state_from_string(std::string_view text);  // throws Error{InvalidArgument}

// The life of one attempt: running until it ends in exactly one of the other states.
enum class AttemptState { Running, Succeeded, Failed, Cancelled, LeaseLost, Released };

std::string_view to_string(AttemptState state);
AttemptState attempt_state_from_string(std::string_view text);  // throws Error{InvalidArgument}

}  // namespace divemesh
