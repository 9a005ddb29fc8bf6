#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "schemas/event.hpp"
#include "storage/catalog.hpp"

namespace divemesh::storage {

// The events table: written by the other stores inside their transactions (append), read by
// watchers of any process.
class EventStore {
public:
    explicit EventStore(Catalog& catalog) : catalog_(catalog) {}

    // Sequence and time are set here; the event goes into the outbox of the webhooks that want it.
    static void append(soci::session& session, Event event);
    // The same for news that make older ones of this type and subject worthless (progress): those
    // are removed, so a watcher may miss them but never the newest, and webhooks are not told.
    static void replace(soci::session& session, Event event);

    // In order of sequence; project "" sees all. At most `limit`.
    std::vector<Event> since(std::int64_t sequence, const std::string& project, int limit);
    std::int64_t newest_sequence();
    std::int64_t oldest_sequence();  // that is kept; 0: none is

private:
    Catalog& catalog_;
};

}  // namespace divemesh::storage
