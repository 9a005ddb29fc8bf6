#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "storage/catalog.hpp"
#include "storage/stage_seconds.hpp"

namespace divemesh::storage {

// Counts of everything, for monitoring the service.
struct Statistics {
    using Counts = std::vector<std::pair<std::string, std::int64_t>>;  // by state

    Counts jobs;
    Counts dives;
    Counts attempts;
    Counts attempt_ms;                  // spent in attempts that have ended
    std::vector<StageSeconds> stages;   // by name
    std::int64_t oldest_queued_ms = 0;  // age of the oldest queued job; 0: none
    std::int64_t lease_overdue_ms =
        0;  // since the end of the oldest lease; 0: none, negative: good
    std::int64_t uploads_open = 0;
    std::int64_t uploads_open_bytes = 0;
    std::int64_t archive_bytes = 0;
    std::int64_t artifact_bytes = 0;
    std::int64_t deliveries_waiting = 0;
};

// Reads all statistics in one read transaction.
Statistics read_statistics(Catalog& catalog);

}  // namespace divemesh::storage
