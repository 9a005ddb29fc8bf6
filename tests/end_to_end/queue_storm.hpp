#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace divemesh {

// Settings of a storm: a client creates many tiny jobs over HTTP while server and workers are
// killed.
struct QueueStorm {
    std::filesystem::path program;             // divemesh
    std::filesystem::path fake_worker;         // a worker with an empty pipeline
    std::string catalog_url = {};              // "": SQLite in the storm's own folder
    std::function<void()> kill_database = {};  // and start it again; empty: it is left alone
    int num_jobs = 300;
    int num_workers = 3;
    int num_kills = 10;
    unsigned seed = 1;
};

struct StormReport {
    int num_succeeded = 0;
    int num_kills = 0;
    int num_database_kills = 0;  // of these
    int num_redriven = 0;        // jobs put back after they lost three workers in a row
    int num_attempts = 0;        // of all jobs, including those of killed workers
    double seconds = 0.0;
    std::vector<std::string> complaints;  // jobs that were lost or took effect twice
};

// Runs a storm. Returns when every job is finished, or after a minute without progress.
StormReport run_queue_storm(const QueueStorm& storm);

}  // namespace divemesh
