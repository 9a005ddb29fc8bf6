#pragma once

#include <cstdint>

#include "schemas/job.hpp"
#include "storage/job_changes.hpp"
#include "storage/job_rows.hpp"
#include "storage/job_store.hpp"

// The retry policy: what happens to a job when its attempt ends without a result.
//
//   bad_data, invalid_argument, too_large, unsupported, gone
//                   failed at once, because a retry cannot help
//   out_of_memory   once more with the settings that take the least memory, then dead
//   lost lease      at once on another worker; dead after three in a row without a renewal
//   put back        (the worker has no disk space or lost its blobs) after a growing pause, as
//   often
//                   as it happens
//   anything else   after a growing pause, dead when the attempts are used up
//
// A cancelled job is not retried, whatever its failure was. An attempt that reports cancelled
// without a request to cancel was ended from outside and is retried.
namespace divemesh::storage {

inline constexpr int kMaxSilentLosses = 3;

// Returns the end of an attempt that failed by itself; `retry_at_ms` is the time of a retry.
AttemptEnd end_of_failed(const Job& job, const Failure& failure, std::int64_t retry_at_ms);

// Returns the end of an attempt that failed because of its worker. It does not count.
AttemptEnd end_of_put_back(const Job& job, const Failure& failure, std::int64_t retry_at_ms);

// Returns the end of an attempt whose worker was killed, froze or lost the network.
AttemptEnd end_of_expired(const ExpiredJob& expired);

// Returns the pause before the next attempt: doubled with every attempt, less up to a half at
// random. So jobs that failed together (e.g. because a disk was gone for a moment) do not come back
// together.
std::int64_t pause_ms(const RetryPause& pause, int num_attempts);

}  // namespace divemesh::storage
