#pragma once

#include "api/services.hpp"

namespace divemesh::api {

// Removes expired deleted dives with their archives and artifacts, except those with a running job.
// Blocks: run it in the pool.
void remove_expired_dives(const Services& services);

// Removes the artifacts of expired deleted results. Blocks as above.
void remove_expired_results(const Services& services);

// Does one round of removing what has expired: deleted dives and results, and results that projects
// do not want to keep, blobs of attempts without a result,
// old events, the log of webhooks, the history of sensors. Logs a failure and retries it in the
// next round. Blocks: run it in the pool.
void clean_up(const Services& services);

// Reports which sensors have fallen silent, are overdue or lost. Blocks as above.
void watch_sensors(const Services& services);

// Creates the reports of schedules that are due. Blocks as above.
void run_schedules(const Services& services);

// Ends the leases of lost workers even if no worker polls. Their jobs are queued again, or
// cancelled if that was requested. Blocks as above.
void end_lost_leases(const Services& services);

}  // namespace divemesh::api
