#pragma once

#include <atomic>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "api/client/stream.hpp"

namespace divemesh::server {

// Returns the client's address, a mapped one as IPv4; the unspecified one if the client has gone.
boost::asio::ip::address client_address(const boost::asio::ip::tcp::socket& socket);

// Returns what counts as one client: an IPv4 address, or the /64 network of an IPv6 address,
// because all of it can belong to one machine.
std::string client_of(const boost::asio::ip::address& address);

// One client's socket. Use it on its strand only, except for what is for any thread.
class Connection : public std::enable_shared_from_this<Connection> {
public:
    using Clock = std::chrono::steady_clock;

    // `tls` null: plain.
    Connection(boost::asio::ip::tcp::socket socket,
               const boost::asio::ip::address& client,
               std::shared_ptr<boost::asio::ssl::context> tls);

    api::client::Stream stream;
    boost::beast::flat_buffer buffer;  // received but not yet parsed bytes
    bool stopping = false;             // no further request is taken

    // End the current work of the connection: gracefully, and immediately. Called on the strand.
    std::function<void()> on_stop;
    std::function<void()> on_abort;

    void stop();   // from any thread
    void abort();  // from any thread

    // What decides which connection is closed when there are too many; for any thread.
    const boost::asio::ip::address& address() const { return address_; }  // of the client
    const std::string& client() const { return client_; }                 // see client_of()
    void note_received() { received_at_ = Clock::now(); }
    Clock::time_point received_at() const { return received_at_; }  // the last byte
    void note_valid_token() { has_token_ = true; }
    bool has_token() const { return has_token_; }
    void set_serving(bool serving) { serving_ = serving; }  // from a header to its response's end
    bool is_serving() const { return serving_; }

private:
    std::shared_ptr<boost::asio::ssl::context> tls_;  // outlives every stream made with it
    boost::asio::ip::address address_;
    std::string client_;
    std::atomic<Clock::time_point> received_at_ = Clock::now();
    std::atomic<bool> has_token_ = false;
    std::atomic<bool> serving_ = false;
};

}  // namespace divemesh::server
