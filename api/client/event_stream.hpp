#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>

#include "api/client/rest_client.hpp"
#include "schemas/event.hpp"

namespace divemesh::api::client {

// The server's events as they happen, over its WebSocket. Throws as HttpConnection does if it
// cannot connect or the connection ends. A new stream with the last `sequence` seen misses no
// event. Without `since` it returns only new events.
class EventStream {
public:
    EventStream(const Account& account, std::optional<std::int64_t> since);
    ~EventStream();

    // Returns the next event; nullopt if no event came in time.
    std::optional<Event> next(std::chrono::milliseconds timeout);

private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

}  // namespace divemesh::api::client
