#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace divemesh {

// Many jobs with next to nothing to do, asked for over HTTP, while server and workers are killed.
struct QueueStorm {
    std::filesystem::path program;      // divemesh
    std::filesystem::path fake_worker;  // a worker with an empty pipeline
    int num_jobs = 300;
    int num_workers = 3;
    int num_kills = 10;
    unsigned seed = 1;
};

struct StormReport {
    int num_succeeded = 0;
    int num_kills = 0;
    int num_redriven = 0;  // hit three times in a row
    int num_attempts = 0;  // of all jobs, those of the killed workers too
    double seconds = 0.0;
    std::vector<std::string> complaints;  // what was lost, or was done twice to effect
};

// Returns when every job is finished, or when nothing has moved for a minute.
StormReport run_queue_storm(const QueueStorm& storm);

}  // namespace divemesh
