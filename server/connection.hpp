#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <functional>
#include <memory>
#include <mutex>
#include <set>

#include "api/client/stream.hpp"

namespace divemesh::server {

// One client's socket. Use it on its strand only, except stop() and abort().
class Connection : public std::enable_shared_from_this<Connection> {
public:
    // `tls` null: plain.
    Connection(boost::asio::ip::tcp::socket socket, std::shared_ptr<boost::asio::ssl::context> tls)
        : stream(std::move(socket), tls.get()), tls_(std::move(tls)) {}

    api::client::Stream stream;
    boost::beast::flat_buffer buffer;  // received but not yet parsed bytes
    bool stopping = false;             // no further request is taken

    // End the current work of the connection: gracefully, and immediately. Called on the strand.
    std::function<void()> on_stop;
    std::function<void()> on_abort;

    void stop();   // from any thread
    void abort();  // from any thread

private:
    std::shared_ptr<boost::asio::ssl::context> tls_;  // outlives every stream made with it
};

// The open connections. Thread-safe.
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
