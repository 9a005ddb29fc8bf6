#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>

#include "api/client/rest_client.hpp"
#include "schemas/event.hpp"

namespace divemesh::api::client {

// The server's events as they happen, over its WebSocket. Throws as HttpConnection when it cannot
// connect or the connection ends; a new one with the last `sequence` seen misses nothing. Without
// `since` it tells only what is new.
class EventStream {
public:
    EventStream(const Account& account, std::optional<std::int64_t> since);
    ~EventStream();

    // The next event; nothing when none came in time.
    std::optional<Event> next(std::chrono::milliseconds timeout);

private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

}  // namespace divemesh::api::client
