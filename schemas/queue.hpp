#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace divemesh {

// The queue of one project, or of all projects. Paused: running jobs continue, but no job starts.
struct Queue {
    std::string project;  // "": the whole queue
    bool paused = false;
    int max_running = 0;   // jobs at a time, intakes not counted; 0: no limit
    int keep_results = 0;  // the newest of each dive and kind; older ones are deleted; 0: all
    std::map<std::string, std::int64_t> num_jobs;  // by state
};

}  // namespace divemesh
