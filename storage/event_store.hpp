#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "schemas/event.hpp"
#include "storage/catalog.hpp"

namespace divemesh::storage {

// The events table. The other stores write it inside their transactions (append); watchers in any
// process read it.
class EventStore {
public:
    explicit EventStore(Catalog& catalog) : catalog_(catalog) {}

    // Appends an event and sets its sequence and time. It also goes into the outbox of the webhooks
    // that subscribe to it.
    static void append(soci::session& session, Event event);
    // Appends an event that makes older ones of its type and subject obsolete (progress), and
    // removes those. So a watcher may miss older events but never the newest. Webhooks do not
    // receive it.
    static void replace(soci::session& session, Event event);

    // Returns events in order of sequence, `limit` at most; project "" sees all.
    std::vector<Event> since(std::int64_t sequence, const std::string& project, int limit);
    std::int64_t newest_sequence();
    std::int64_t oldest_sequence();  // of the kept events; 0: there are none

private:
    Catalog& catalog_;
};

}  // namespace divemesh::storage
