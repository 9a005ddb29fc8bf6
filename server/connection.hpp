#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <functional>
#include <memory>
#include <mutex>
#include <set>

#include "api/stream.hpp"

namespace divemesh::server {

// One client's socket. Everything here is for its strand alone, except stop() and abort().
class Connection : public std::enable_shared_from_this<Connection> {
public:
    // `tls` null: plain.
    Connection(boost::asio::ip::tcp::socket socket, std::shared_ptr<boost::asio::ssl::context> tls)
        : stream(std::move(socket), tls.get()), tls_(std::move(tls)) {}

    api::Stream stream;
    boost::beast::flat_buffer buffer;  // bytes that came but are not parsed yet
    bool stopping = false;             // no further request is taken

    // What ends the present occupation gracefully, and at once; called on the strand.
    std::function<void()> on_stop;
    std::function<void()> on_abort;

    void stop();   // from any thread
    void abort();  // from any thread

private:
    std::shared_ptr<boost::asio::ssl::context> tls_;  // lives as long as what was made with it
};

// The connections that are open. Thread-safe.
class Connections {
public:
    bool add(const std::shared_ptr<Connection>& connection, std::size_t limit);  // false: too many
    void remove(const std::shared_ptr<Connection>& connection);
    std::size_t count() const;
    void stop_all();
    void abort_all();

private:
    std::set<std::shared_ptr<Connection>> copy() const;

    mutable std::mutex mutex_;
    std::set<std::shared_ptr<Connection>> open_;
    bool stopping_ = false;
};

}  // namespace divemesh::server
