#include "storage/job_ends.hpp"

#include <algorithm>
#include <random>
#include <string>

namespace divemesh::storage {
namespace {

bool is_hopeless(ErrorCode code) {
    return code == ErrorCode::BadData || code == ErrorCode::InvalidArgument ||
           code == ErrorCode::TooLarge || code == ErrorCode::Unsupported || code == ErrorCode::Gone;
}

Failure crash_loop(int num_losses) {
    return {.code = ErrorCode::Unavailable,
            .message = std::to_string(num_losses) +
                       " workers in a row were lost right after they took this job: it may bring "
                       "their machines down",
            .remedy =
                "check the logs of its attempts and of those machines (memory, disk), then retry "
                "it on a separate worker"};
}

}  // namespace

AttemptEnd end_of_failed(const Job& job, const Failure& failure, std::int64_t retry_at_ms) {
    AttemptEnd end{.attempt = AttemptState::Failed, .job = JobState::Queued, .failure = failure};
    if (is_hopeless(failure.code)) {
        end.job = JobState::Failed;
    } else if (job.cancel_requested) {
        end.attempt = AttemptState::Cancelled;
        end.job = JobState::Cancelled;
    } else if (failure.code == ErrorCode::OutOfMemory && !job.lowered) {
        end.lowered = true;
        end.counts = job.num_attempts < job.max_attempts;  // one more attempt in any case
    } else if (failure.code == ErrorCode::OutOfMemory || job.num_attempts >= job.max_attempts) {
        end.job = JobState::Dead;
    } else {
        end.not_before_ms = retry_at_ms;
    }
    return end;
}

AttemptEnd end_of_put_back(const Job& job, const Failure& failure, std::int64_t retry_at_ms) {
    if (job.cancel_requested)
        return {.attempt = AttemptState::Cancelled, .job = JobState::Cancelled, .failure = failure};
    return {.attempt = AttemptState::Failed,
            .job = JobState::Queued,
            .failure = failure,
            .not_before_ms = retry_at_ms,
            .counts = false};
}

AttemptEnd end_of_expired(const ExpiredJob& expired) {
    const Job& job = expired.job;
    AttemptEnd end{
        .attempt = AttemptState::LeaseLost,
        .job = JobState::Queued,
        .failure = {.code = ErrorCode::Unavailable,
                    .message =
                        "the worker did not renew its lease: it was killed or lost its network",
                    .remedy = "check the worker; the job runs again automatically"},
        .num_silent_losses = expired.renewed ? 0 : expired.num_silent_losses + 1};
    if (job.cancel_requested) {
        end.job = JobState::Cancelled;
    } else if (end.num_silent_losses >= kMaxSilentLosses) {
        end.job = JobState::Dead;
        end.failure = crash_loop(end.num_silent_losses);
    } else if (job.num_attempts >= job.max_attempts) {
        end.job = JobState::Dead;
        end.failure.remedy = "check the workers, then use `divemesh retry`";
    }
    return end;
}

std::int64_t pause_ms(const RetryPause& pause, int num_attempts) {
    static thread_local std::mt19937_64 random{std::random_device{}()};
    const int doublings = std::clamp(num_attempts - 1, 0, 20);
    const auto full = std::min<std::int64_t>(pause.first.count() << doublings, pause.max.count());
    return std::uniform_int_distribution<std::int64_t>(full / 2, full)(random);
}

}  // namespace divemesh::storage
