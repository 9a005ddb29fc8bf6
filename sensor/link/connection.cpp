#include "sensor/link/connection.hpp"

#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/use_future.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/field.hpp>
#include <boost/beast/http/status.hpp>
#include <boost/beast/websocket.hpp>
#include <deque>
#include <future>
#include <linux/sockios.h>
#include <optional>
#include <sys/ioctl.h>
#include <utility>

#include "api/client/dial.hpp"

namespace divemesh::sensor {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using Clock = Connection::Clock;

constexpr std::size_t kMaxConnectionTextBytes = std::size_t{1} << 20;
// Small, because bytes in the kernel can neither be overtaken nor counted as under way.
constexpr int kSendBufferBytes = 64 << 10;

Error refusal(const std::string& url, int status) {
    const ErrorCode code = status == 401   ? ErrorCode::Unauthorized
                           : status == 403 ? ErrorCode::Forbidden
                           : status == 404 ? ErrorCode::NotFound
                           : status == 429 ? ErrorCode::TooMany
                           : status >= 500 ? ErrorCode::TooMany
                                           : ErrorCode::Unsupported;
    std::string what = url;
    what.append(" refused the sensor's stream (HTTP ").append(std::to_string(status)).append(")");
    if (status == 401 || status == 403)
        what.append(": use a token with the scope sensor:push for this sensor");
    return {code, what};
}

}  // namespace

struct Connection::Implementation {
    Implementation(const api::client::Account& account, std::chrono::milliseconds timeout)
        : tls(api::client::client_tls(account.server)),
          socket(api::client::dial(context, account.server, tls.get(), timeout)) {}

    std::unique_ptr<asio::ssl::context> tls;
    asio::io_context context;
    websocket::stream<api::client::Stream, false> socket;  // images are compressed already
    beast::flat_buffer buffer;
    struct Frame {
        std::string bytes;
        bool is_binary = false;
    };
    std::deque<Frame> frames;  // the first is being written
    std::vector<std::string> texts;
    Clock::time_point heard_at = Clock::now();
    Clock::time_point moved_at = Clock::now();
    int num_unsent_before = 0;
    bool is_pinging = false;
    bool is_open = true;
    int close_code = 0;
    std::string why;

    void shake_hands(const api::client::Account& account,
                     const std::string& sensor_id,
                     std::chrono::milliseconds timeout) {
        socket.next_layer().expires_never();  // from here on the WebSocket has timeouts of its own
        socket.set_option(
            websocket::stream_base::timeout{timeout, websocket::stream_base::none(), false});
        socket.set_option(websocket::stream_base::decorator([&](websocket::request_type& request) {
            for (const auto& [name, value] : api::client::authorization(account))
                request.set(name, value);
        }));
        socket.read_message_max(kMaxConnectionTextBytes);
        socket.control_callback([this](auto, auto) { heard_at = moved_at = Clock::now(); });
        boost::system::error_code ignored;
        socket.next_layer().socket().set_option(
            asio::socket_base::send_buffer_size(kSendBufferBytes), ignored);
        std::string target = account.server.base_path;
        target.append("/api/v1/sensors/")
            .append(api::client::percent_encode(sensor_id))
            .append("/stream");
        websocket::response_type response;
        auto shaken =
            socket.async_handshake(response, account.server.authority(), target, asio::use_future);
        // Does not run until all work is done, because a timer runs for its full time.
        context.restart();
        while (shaken.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
            context.run_one();
        try {
            shaken.get();
        } catch (const beast::system_error& error) {
            if (error.code() == websocket::error::upgrade_declined)
                throw refusal(account.server.url(), static_cast<int>(response.result_int()));
            throw;
        }
    }

    void read() {
        socket.async_read(buffer, [this](const boost::system::error_code& failure, std::size_t) {
            if (failure) return end(failure);
            heard_at = moved_at = Clock::now();
            texts.push_back(beast::buffers_to_string(buffer.data()));
            buffer.clear();
            read();
        });
    }

    void write() {
        socket.binary(frames.front().is_binary);
        socket.async_write(asio::buffer(frames.front().bytes),
                           [this](const boost::system::error_code& failure, std::size_t) {
                               if (failure) return end(failure);
                               frames.pop_front();
                               if (!frames.empty()) write();
                           });
    }

    void send(Frame frame) {
        frames.push_back(std::move(frame));
        if (is_open && frames.size() == 1) write();
    }

    void end(const boost::system::error_code& failure) {
        if (!is_open) return;
        is_open = false;
        if (failure == websocket::error::closed) {
            close_code = socket.reason().code;
            why = std::string(socket.reason().reason.c_str());
        }
        if (why.empty()) why = failure.message();
    }

    int num_unsent() {
        int bytes = 0;
        const int descriptor = socket.next_layer().socket().native_handle();
        if (::ioctl(descriptor, SIOCOUTQ, &bytes) != 0) bytes = 0;
        for (const Frame& frame : frames) bytes += static_cast<int>(frame.bytes.size());
        return bytes;
    }

    void watch_bytes() {
        const int unsent = num_unsent();
        if (unsent < num_unsent_before) moved_at = Clock::now();
        num_unsent_before = unsent;
    }
};

Connection::Connection(const api::client::Account& account,
                       const std::string& sensor_id,
                       std::chrono::milliseconds timeout) {
    try {
        implementation_ = std::make_unique<Implementation>(account, timeout);
        implementation_->shake_hands(account, sensor_id, timeout);
    } catch (const beast::system_error& error) {
        throw api::client::connection_error(account.server, error.code());
    }
    implementation_->read();
}

Connection::~Connection() = default;

void Connection::send_text(std::string frame) { implementation_->send({std::move(frame), false}); }

void Connection::send_binary(std::string frame) { implementation_->send({std::move(frame), true}); }

void Connection::ping() {
    auto& own = *implementation_;
    if (own.is_pinging || !own.is_open) return;
    own.is_pinging = true;
    own.socket.async_ping({}, [&own](const boost::system::error_code&) { own.is_pinging = false; });
}

void Connection::run(std::chrono::milliseconds time) {
    auto& own = *implementation_;
    own.context.restart();
    own.context.run_one_for(time);
    own.context.poll();
    own.watch_bytes();
}

void Connection::close(std::chrono::milliseconds time) {
    auto& own = *implementation_;
    if (!own.is_open) return;
    bool is_closed = false;
    own.socket.async_close(websocket::close_code::going_away,
                           [&](const boost::system::error_code&) { is_closed = true; });
    const auto until = Clock::now() + time;
    own.context.restart();
    while (!is_closed && Clock::now() < until)
        own.context.run_one_for(std::chrono::milliseconds(20));
    own.is_open = false;
    // The handler must not outlive the buffer that it writes to.
    if (!is_closed) implementation_->socket.next_layer().close();
    own.context.restart();
    while (!is_closed && own.context.run_one_for(time) > 0) continue;
}

std::vector<std::string> Connection::take_texts() {
    return std::exchange(implementation_->texts, {});
}

Clock::time_point Connection::heard_at() const { return implementation_->heard_at; }
Clock::time_point Connection::moved_at() const { return implementation_->moved_at; }
bool Connection::has_unsent() const { return implementation_->num_unsent() > 0; }
bool Connection::is_open() const { return implementation_->is_open; }
int Connection::close_code() const { return implementation_->close_code; }
const std::string& Connection::why() const { return implementation_->why; }

}  // namespace divemesh::sensor
