#pragma once

#include "api/services.hpp"
#include "server/event_hub.hpp"
#include "server/server.hpp"

namespace divemesh::server {

// What every connection needs; it outlives all connections.
struct SessionContext {
    api::Services services;
    EventHub& events;
    Timeouts timeouts;
};

}  // namespace divemesh::server
