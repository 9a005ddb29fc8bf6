#pragma once

#include <string_view>

namespace divemesh {

// Why a job waits although it is its turn. Readers must expect further words: later versions may
// add some.
enum class WaitReason {
    Paused,       // a user holds this job
    Parent,       // a job that must succeed first has not
    QueuePaused,  // a user holds the queue, or that of its project
    Limit,        // as many jobs run as the queue or the project may run
    Retry,        // an attempt failed; the next one has to wait a moment
    Worker,       // no worker is alive
    Drain,        // every worker that is alive takes no more jobs, on request
    Disk,         // the workers' disk is nearly full
    Storage,      // the workers do not find the blobs of this catalog
};

std::string_view to_string(WaitReason reason);

}  // namespace divemesh
