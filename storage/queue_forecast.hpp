#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>

#include "schemas/job.hpp"
#include "storage/catalog.hpp"

namespace divemesh::storage {

// Where a queued job stands and when it may start: a picture of the queue that is renewed when it
// is older than `max_age`, so that many who ask cost one look. The start is simulated from measured
// speeds (storage/job_speeds.hpp) and the slots of the workers that are alive; limits of projects
// are left out of it. Thread-safe.
class QueueForecast {
public:
    explicit QueueForecast(std::chrono::milliseconds max_age = std::chrono::seconds(2));
    ~QueueForecast();

    // Nothing unless it is queued. Times are rounded to ten seconds. A new picture is taken by
    // `catalog`; Error{Unavailable} when one is due and that may not wait.
    std::optional<Forecast> of(const Job& job, Catalog& catalog);

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
