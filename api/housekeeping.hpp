#pragma once

#include "api/services.hpp"

namespace divemesh::api {

// Removes deleted dives that have expired, with their archives and artifacts, but those of which a
// job still runs. Blocks: for the pool.
void remove_expired_dives(const Services& services);

// One round of removing what has had its time: deleted dives that have expired, blobs of attempts
// that came to nothing, old events, the log of webhooks, the history of sensors. What fails is
// logged and comes up again in the next round. Blocks: for the pool.
void clean_up(const Services& services);

// Tells which sensors have fallen silent, are overdue or lost. As above.
void watch_sensors(const Services& services);

// Makes the reports of schedules that are due. As above.
void run_schedules(const Services& services);

// Ends the leases of workers that are gone, so that their jobs are queued again, or cancelled when
// that was asked for, though no worker polls. As above.
void end_lost_leases(const Services& services);

}  // namespace divemesh::api
