#include "tests/flaky_proxy.hpp"

#include <algorithm>
#include <atomic>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <thread>
#include <vector>

namespace divemesh {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

constexpr auto kAwaitErrors = asio::as_tuple(asio::use_awaitable);
constexpr double kChunksPerSecond = 50.0;
constexpr std::size_t kChunkBytes = std::size_t{64} << 10;

void reset(tcp::socket& socket) {
    boost::system::error_code ignored;
    socket.set_option(asio::socket_base::linger(true, 0), ignored);
    socket.close(ignored);
}

struct Link {
    tcp::socket client;
    tcp::socket server;
    bool is_cut = false;
};

}  // namespace

struct FlakyProxy::Implementation {
    Implementation(int port, const BadLink& bad)
        : bad_link(bad),
          target(asio::ip::address_v4::loopback(), static_cast<std::uint16_t>(port)),
          acceptor(io, {asio::ip::address_v4::loopback(), 0}) {}

    asio::awaitable<void> accept() {
        for (;;) {
            auto [error, socket] = co_await acceptor.async_accept(kAwaitErrors);
            if (error) co_return;
            ++num_connections;
            asio::co_spawn(io, serve(std::move(socket)), asio::detached);
        }
    }

    asio::awaitable<void> serve(tcp::socket client) {
        auto link = std::make_shared<Link>(Link{std::move(client), tcp::socket(io)});
        const auto [error] = co_await link->server.async_connect(target, kAwaitErrors);
        if (error) co_return;
        links.push_back(link);  // kept open, so that neither side notices the cut
        asio::co_spawn(io, pass_down(link), asio::detached);
        co_await pass_up(link);
    }

    asio::awaitable<void> pass_up(std::shared_ptr<Link> link) {
        // A slow link passes a little all the time, not much at once and then nothing for long.
        const auto write_bytes = static_cast<std::size_t>(bad_link.bytes_per_s / kChunksPerSecond);
        std::vector<char> buffer(write_bytes > 0 ? std::min(write_bytes, kChunkBytes)
                                                 : kChunkBytes);
        asio::steady_timer pause(io);
        for (;;) {
            const auto [error, n] =
                co_await link->client.async_read_some(asio::buffer(buffer), kAwaitErrors);
            if (link->is_cut) co_return;
            if (error) break;
            num_bytes_since_cut += static_cast<std::int64_t>(n);
            num_bytes += static_cast<std::int64_t>(n);
            if (num_bytes_since_cut > bad_link.cut_after_bytes && num_cuts < bad_link.num_cuts) {
                cut(*link);
                co_return;
            }
            const auto [failure, sent] =
                co_await asio::async_write(link->server, asio::buffer(buffer, n), kAwaitErrors);
            if (failure || link->is_cut) break;
            if (bad_link.bytes_per_s <= 0.0) continue;
            pause.expires_after(std::chrono::microseconds(
                static_cast<std::int64_t>(static_cast<double>(n) / bad_link.bytes_per_s * 1e6)));
            co_await pause.async_wait(kAwaitErrors);
        }
        boost::system::error_code ignored;
        link->server.shutdown(tcp::socket::shutdown_send, ignored);
    }

    asio::awaitable<void> pass_down(std::shared_ptr<Link> link) {
        std::vector<char> buffer(kChunkBytes);
        for (;;) {
            const auto [error, n] =
                co_await link->server.async_read_some(asio::buffer(buffer), kAwaitErrors);
            if (link->is_cut) co_return;  // drops what the server sends
            if (error) break;
            const auto [failure, sent] =
                co_await asio::async_write(link->client, asio::buffer(buffer, n), kAwaitErrors);
            if (failure || link->is_cut) co_return;
        }
        boost::system::error_code ignored;
        link->client.shutdown(tcp::socket::shutdown_send, ignored);
    }

    void cut(Link& link) {
        ++num_cuts;
        num_bytes_since_cut = 0;
        link.is_cut = true;
        if (bad_link.cut != Cut::Stall) reset(link.client);
        if (bad_link.cut == Cut::Reset) reset(link.server);
    }

    BadLink bad_link;
    asio::io_context io;
    tcp::endpoint target;
    tcp::acceptor acceptor;
    std::vector<std::shared_ptr<Link>> links;
    std::int64_t num_bytes_since_cut = 0;
    std::atomic<int> num_cuts = 0;
    std::atomic<int> num_connections = 0;
    std::atomic<std::int64_t> num_bytes = 0;
    std::jthread thread;
};

FlakyProxy::FlakyProxy(int target_port, const BadLink& link)
    : implementation_(std::make_unique<Implementation>(target_port, link)) {
    Implementation& self = *implementation_;
    asio::co_spawn(self.io, self.accept(), asio::detached);
    self.thread = std::jthread([&self] { self.io.run(); });
}

FlakyProxy::~FlakyProxy() {
    implementation_->io.stop();
    implementation_->thread.join();
}

int FlakyProxy::port() const { return implementation_->acceptor.local_endpoint().port(); }
int FlakyProxy::num_cuts() const { return implementation_->num_cuts; }
int FlakyProxy::num_connections() const { return implementation_->num_connections; }
std::int64_t FlakyProxy::num_bytes() const { return implementation_->num_bytes; }

}  // namespace divemesh
