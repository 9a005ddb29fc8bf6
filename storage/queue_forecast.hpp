#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "schemas/job.hpp"
#include "storage/catalog.hpp"

namespace divemesh::storage {

// Position and start time of queued jobs, and why jobs wait, from a snapshot of the queue. The
// snapshot is renewed when it is older than `max_age`, so that many callers cost one read. The
// start is simulated from measured speeds (storage/job_speeds.hpp) and the slots of the workers
// that take jobs; it is unknown for a job that something else than the jobs before it keeps back.
// Thread-safe.
class QueueForecast {
public:
    explicit QueueForecast(std::chrono::milliseconds max_age = std::chrono::seconds(2));
    ~QueueForecast();

    // Returns nullopt unless the job is queued. Times are rounded to ten seconds. Takes a new
    // snapshot by `catalog`; throws Error{Unavailable} if one is due and the catalog may not wait.
    std::optional<Forecast> of(const Job& job, Catalog& catalog);
    // Returns ShownJob::waits_for, in the same way.
    std::string waits_for(const Job& job, Catalog& catalog);

    struct Snapshot;

private:
    std::shared_ptr<const Snapshot> snapshot(Catalog& catalog);

    std::chrono::milliseconds max_age_;
    std::mutex mutex_;
    std::shared_ptr<const Snapshot> newest_;
    std::chrono::steady_clock::time_point taken_;
    bool being_taken_ = false;
};

}  // namespace divemesh::storage
