#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <stop_token>
#include <string>

#include "worker/runner/child_process.hpp"

namespace divemesh::runner {

// Minimum scratch space of an attempt, beyond min_free_bytes.
inline constexpr std::int64_t kMinScratch_bytes = std::int64_t{64} << 20;

// Configuration of a worker: where its data is, and the limits of its attempts.
struct WorkerConfig {
    std::string catalog_url;
    std::string blobs_url;
    std::filesystem::path work_folder;        // scratch of running attempts
    std::filesystem::path cache_folder = {};  // of stages; empty: no cache
    std::int64_t cache_bytes = 0;
    std::filesystem::path executable = "/proc/self/exe";  // run as: executable attempt REQUEST
    int num_slots = 1;                                    // jobs at a time
    int num_threads = 0;                                  // per job; 0: as the job's options say
    std::chrono::milliseconds lease = std::chrono::seconds(20);
    std::chrono::milliseconds renew_every = std::chrono::seconds(5);
    std::chrono::milliseconds poll_every = std::chrono::milliseconds(500);
    std::chrono::milliseconds deadline = std::chrono::hours(48);  // of one attempt
    std::chrono::milliseconds stall = std::chrono::hours(2);  // without a message from the child
    std::chrono::milliseconds cancel_grace = std::chrono::seconds(5);  // SIGTERM, then SIGKILL
    std::int64_t scratch_bytes = 0;  // of one attempt; 0: its share of the free space at its start
    // No attempt starts with less on the disk.
    std::int64_t min_free_bytes = std::int64_t{256} << 20;
    ProcessLimits limits;
};

// The parent process of a worker: claims jobs, runs each attempt in a child, renews the lease by
// timer and publishes the results. Returns when `stop` is requested, after it has returned running
// attempts to the queue. Throws Error{Unavailable} if catalog or blob store are not there (it
// creates neither) or do not belong together.
void run_worker(const WorkerConfig& config, std::stop_token stop);

}  // namespace divemesh::runner
