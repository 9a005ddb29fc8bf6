#pragma once

#include <cstdint>

#include "schemas/job.hpp"
#include "storage/job_changes.hpp"
#include "storage/job_rows.hpp"
#include "storage/job_store.hpp"

// The retry policy: what becomes of a job when its attempt ends without a result.
//
//   bad_data, invalid_argument, too_large, unsupported, gone   failed at once: trying again cannot
//   help
//   out_of_memory   once more with settings that take the least memory, then dead
//   lost lease      at once elsewhere; dead after three in a row that never renewed their lease
//   anything else   after a growing pause, dead when the attempts are used up
//
// Who cancelled a job does not want it tried again, whatever it failed of. An attempt that says
// cancelled without anybody having asked was ended from outside: that is retried.
namespace divemesh::storage {

inline constexpr int kMaxSilentLosses = 3;

AttemptEnd end_of_failed(const Job& job, const Failure& failure, std::int64_t retry_at_ms);

// A worker was killed, froze or lost the network.
AttemptEnd end_of_expired(const ExpiredJob& expired);

// Doubled with every attempt, less up to a half at random: jobs that failed together (a database or
// a disk that was gone for a moment) do not come back together.
std::int64_t pause_ms(const RetryPause& pause, int num_attempts);

}  // namespace divemesh::storage
