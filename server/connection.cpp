#include "server/connection.hpp"

#include <boost/asio/post.hpp>

namespace divemesh::server {

namespace asio = boost::asio;

void Connection::stop() {
    asio::post(stream.get_executor(), [self = shared_from_this()] {
        self->stopping = true;
        if (self->on_stop) self->on_stop();
    });
}

void Connection::abort() {
    asio::post(stream.get_executor(), [self = shared_from_this()] {
        self->stopping = true;
        if (self->on_abort) self->on_abort();
        self->stream.close();
    });
}

bool Connections::add(const std::shared_ptr<Connection>& connection, std::size_t limit) {
    const std::lock_guard lock(mutex_);
    if (stopping_ || open_.size() >= limit) return false;
    open_.insert(connection);
    return true;
}

void Connections::remove(const std::shared_ptr<Connection>& connection) {
    const std::lock_guard lock(mutex_);
    open_.erase(connection);
}

std::size_t Connections::count() const {
    const std::lock_guard lock(mutex_);
    return open_.size();
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

std::set<std::shared_ptr<Connection>> Connections::copy() const {
    const std::lock_guard lock(mutex_);
    return open_;
}

}  // namespace divemesh::server
