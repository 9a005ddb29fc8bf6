#include "server/connections.hpp"

#include <algorithm>

namespace divemesh::server {

bool Connections::add(const std::shared_ptr<Connection>& connection) {
    const std::lock_guard lock(mutex_);
    if (stopping_ || !make_room(*connection)) return false;
    open_.insert(connection);
    return true;
}

void Connections::remove(const std::shared_ptr<Connection>& connection) {
    const std::lock_guard lock(mutex_);
    open_.erase(connection);
    aborted_.erase(connection);
}

std::size_t Connections::count() const {
    const std::lock_guard lock(mutex_);
    return open_.size() + aborted_.size();
}

void Connections::stop_all() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    for (const auto& connection : copy()) connection->stop();
}

void Connections::abort_all() {
    for (const auto& connection : copy()) connection->abort();
}

bool Connections::make_room(const Connection& for_connection) {
    const auto& address = for_connection.address();
    const bool is_limited = limits_.per_address > 0 && !address.is_loopback() &&
                            !limits_.many_clients.contains(address);
    if (is_limited && !make_room_of_client(for_connection.client())) return false;
    const std::size_t num_for_any = limits_.total - reserved_connections(limits_.total);
    if (open_.size() < num_for_any) return true;
    if (open_.size() < limits_.total && num_without_token() < num_for_any) return true;
    auto which = most_silent("", false);
    if (which == open_.end()) which = most_silent("", true);
    if (which == open_.end()) return false;
    abort(which);
    return true;
}

bool Connections::make_room_of_client(const std::string& client) {
    if (open_.size() < limits_.per_address || num_of(client) < limits_.per_address) return true;
    auto which = most_silent(client, false);
    if (which == open_.end()) which = most_silent(client, true);
    if (which == open_.end()) return false;
    abort(which);
    return true;
}

void Connections::abort(Open::iterator which) {
    (*which)->abort();
    aborted_.insert(*which);
    open_.erase(which);
}

// `of_client` "": of any.
Connections::Open::iterator Connections::most_silent(const std::string& of_client,
                                                     bool with_token) {
    auto found = open_.end();
    for (auto it = open_.begin(); it != open_.end(); ++it) {
        const Connection& connection = **it;
        if (connection.has_token() != with_token || (with_token && connection.is_serving()))
            continue;
        if (!of_client.empty() && connection.client() != of_client) continue;
        if (found == open_.end() || connection.received_at() < (*found)->received_at()) found = it;
    }
    return found;
}

std::size_t Connections::num_of(const std::string& client) const {
    return static_cast<std::size_t>(
        std::count_if(open_.begin(), open_.end(), [&](const auto& connection) {
            return connection->client() == client;
        }));
}

std::size_t Connections::num_without_token() const {
    return static_cast<std::size_t>(
        std::count_if(open_.begin(), open_.end(), [](const auto& connection) {
            return !connection->has_token();
        }));
}

std::vector<std::shared_ptr<Connection>> Connections::copy() const {
    const std::lock_guard lock(mutex_);
    std::vector<std::shared_ptr<Connection>> all(open_.begin(), open_.end());
    all.insert(all.end(), aborted_.begin(), aborted_.end());
    return all;
}

}  // namespace divemesh::server
