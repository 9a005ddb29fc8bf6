#pragma once

#include <cstdint>
#include <string>

namespace divemesh {

// A worker process as the catalog stores it. Times are unix milliseconds of the catalog's clock.
struct Worker {
    std::string name;  // host:pid:random
    int num_slots = 1;
    int num_running = 0;
    bool draining = false;  // finishes its jobs and takes no more
    bool alive = false;     // heard of recently
    std::string waits_for;  // why it takes no jobs: a word of WaitReason; "": it takes them
    std::int64_t started_at_ms = 0;
    std::int64_t seen_at_ms = 0;
};

}  // namespace divemesh
