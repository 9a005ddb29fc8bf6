#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "api/webhook_target.hpp"
#include "server/connection.hpp"

namespace divemesh::server {

// How many connections may be open.
struct ConnectionLimits {
    std::size_t total = 2000;
    std::size_t per_address = 256;        // 0: no limit
    api::AllowedNetworks many_clients{};  // addresses without that limit; loopback is one of them
};

// Returns how many of `total` connections are kept for clients that have sent a valid token.
constexpr std::size_t reserved_connections(std::size_t total) { return total / 4; }

// The open connections. Thread-safe.
//
// If there are too many, in all or of one address, the connection goes that has been silent for
// longest: first one that has sent no valid token, then one between two requests. A connection that
// serves a request with a valid token is never closed for another.
class Connections {
public:
    explicit Connections(ConnectionLimits limits) : limits_(std::move(limits)) {}

    // Returns false if the connection is one too many. Aborts those that make room for it.
    bool add(const std::shared_ptr<Connection>& connection);
    void remove(const std::shared_ptr<Connection>& connection);
    std::size_t count() const;  // of those that are aborted too, until they have ended
    void stop_all();
    void abort_all();

private:
    using Open = std::set<std::shared_ptr<Connection>>;

    bool make_room(const Connection& for_connection);
    bool make_room_of_client(const std::string& client);
    void abort(Open::iterator which);
    Open::iterator most_silent(const std::string& of_client, bool with_token);  // or end
    std::size_t num_of(const std::string& client) const;
    std::size_t num_without_token() const;
    std::vector<std::shared_ptr<Connection>> copy() const;

    ConnectionLimits limits_;
    mutable std::mutex mutex_;
    Open open_;
    Open aborted_;  // for others; they have not ended yet
    bool stopping_ = false;
};

}  // namespace divemesh::server
