#pragma once

#include <string>

// The queues that hold jobs back, as subqueries that return their projects; '' is the queue of all
// projects.
namespace divemesh::storage {

inline const std::string kPausedQueues = "(SELECT project FROM queues WHERE paused = 1)";

// Queues that run as many jobs as they may. Intakes are quick and users on a boat wait for them, so
// no limit applies to them.
inline const std::string kFullQueues =
    "(SELECT project FROM queues WHERE max_running > 0 AND max_running <="
    " (SELECT COUNT(*) FROM jobs AS running WHERE running.state = 'running'"
    "   AND running.kind <> 'intake'"
    "   AND (queues.project = '' OR running.project = queues.project)))";

}  // namespace divemesh::storage
