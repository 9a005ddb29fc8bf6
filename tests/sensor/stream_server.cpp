#include "tests/sensor/stream_server.hpp"

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <condition_variable>
#include <list>
#include <mutex>
#include <poll.h>
#include <sys/socket.h>
#include <thread>

namespace divemesh::sensor {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using nlohmann::json;

void add_messages(const json& report, Heard heard, std::vector<Heard>& all) {
    heard.boot_id = report.at("boot_id");
    if (report.contains("lost")) {
        heard.kind = "lost";
        heard.body = report["lost"];
        all.push_back(heard);
    }
    for (const json& message : report.value("messages", json::array())) {
        heard.sequence = message.at("seq");
        heard.is_historical = message.value("historical", false);
        for (const char* kind : {"hello", "status", "preview", "outcome"})
            if (message.contains(kind)) {
                heard.kind = kind;
                heard.body = message[kind];
            }
        all.push_back(heard);
    }
}

std::vector<Heard> messages_in(const std::string& frame, bool is_binary, int connection) {
    Heard heard;
    heard.connection = connection;
    heard.num_bytes = frame.size();
    heard.at = std::chrono::steady_clock::now();
    std::vector<Heard> all;
    if (!is_binary) {
        add_messages(json::parse(frame), heard, all);
        return all;
    }
    std::size_t length = 0;
    for (int i = 0; i < 4; ++i)
        length = length << 8 | static_cast<unsigned char>(frame.at(static_cast<std::size_t>(i)));
    json header = json::parse(frame.substr(4, length));
    add_messages({{"boot_id", header.at("boot_id")}, {"messages", {header}}}, heard, all);
    return all;
}

}  // namespace

struct StreamServer::Implementation {
    using Socket = websocket::stream<tcp::socket, false>;

    asio::io_context context;
    tcp::acceptor acceptor{context, {asio::ip::make_address("127.0.0.1"), 0}};
    mutable std::mutex mutex;
    mutable std::condition_variable changed;
    bool answers = true;
    bool stalls = false;
    bool stops = false;
    int refusal = 0;
    int close_code = 0;
    std::int64_t time_ms = 1'700'000'000'000;
    std::string refused_kind;
    std::vector<Heard> heard;
    int num_connections = 0;
    int current = -1;  // the descriptor of the connection that is there
    std::vector<std::string> outgoing;
    std::list<std::thread> threads;
    std::thread accepting{[this] { accept(); }};

    void accept() {
        while (true) {
            beast::error_code failure;
            tcp::socket socket(context);
            acceptor.accept(socket, failure);
            const std::lock_guard lock(mutex);
            if (stops || failure) return;
            threads.emplace_back(
                [this, number = num_connections++, moved = std::move(socket)]() mutable {
                    try {
                        serve(number, std::move(moved));
                    } catch (const std::exception&) {
                        return;  // cut
                    }
                });
            changed.notify_all();
        }
    }

    void serve(int number, tcp::socket accepted) {
        beast::flat_buffer buffer;
        http::request<http::string_body> request;
        http::read(accepted, buffer, request);
        {
            const std::lock_guard lock(mutex);
            if (refusal != 0) {
                http::response<http::empty_body> response(static_cast<http::status>(refusal), 11);
                response.prepare_payload();
                http::write(accepted, response);
                return;
            }
            current = accepted.native_handle();
        }
        Socket socket(std::move(accepted));
        socket.accept(request);
        write(socket, {{"welcome", {{"time_ms", now_ms()}}}});
        beast::flat_buffer frame;
        while (talk(socket, frame, number)) continue;
        const std::lock_guard lock(mutex);
        current = -1;
    }

    std::int64_t now_ms() {
        const std::lock_guard lock(mutex);
        return time_ms;
    }
    static void write(Socket& socket, const json& frame) {
        socket.text(true);
        socket.write(asio::buffer(frame.dump()));
    }

    bool talk(Socket& socket, beast::flat_buffer& buffer, int number) {
        std::vector<std::string> frames;
        int code = 0;
        bool reads = true;
        {
            const std::lock_guard lock(mutex);
            reads = !stalls || stops;
            frames.swap(outgoing);
            std::swap(code, close_code);
        }
        for (const std::string& frame : frames) socket.write(asio::buffer(frame));
        if (code != 0) {
            socket.close(websocket::close_reason(static_cast<websocket::close_code>(code), "test"));
            return false;
        }
        pollfd readable{socket.next_layer().native_handle(), POLLIN, 0};
        if (::poll(&readable, reads ? 1 : 0, 10) == 0) return true;
        socket.read(buffer);
        const auto messages =
            messages_in(beast::buffers_to_string(buffer.data()), socket.got_binary(), number);
        buffer.clear();
        std::vector<json> replies;
        {
            const std::lock_guard lock(mutex);
            heard.insert(heard.end(), messages.begin(), messages.end());
            changed.notify_all();
            if (!answers) return true;
            for (const Heard& message : messages) replies.push_back(reply_to(message));
        }
        for (const json& reply : replies) write(socket, reply);
        return true;
    }

    json reply_to(const Heard& message) const {
        if (message.kind == refused_kind)
            return {{"refused", {{"status", 400}}}, {"messages", {message.sequence}}};
        json committed = json::array();
        if (message.kind != "lost") committed.push_back({message.sequence, message.sequence});
        return {{"answer", {{"boot_id", message.boot_id}}}, {"committed", committed}};
    }
};

StreamServer::StreamServer() : implementation_(std::make_unique<Implementation>()) {}

StreamServer::~StreamServer() {
    auto& own = *implementation_;
    {
        const std::lock_guard lock(own.mutex);
        own.stops = true;
        if (own.current >= 0) ::shutdown(own.current, SHUT_RDWR);
    }
    ::shutdown(own.acceptor.native_handle(), SHUT_RDWR);
    own.accepting.join();
    cut();
    for (std::thread& thread : own.threads) thread.join();
}

std::string StreamServer::url() const {
    return "http://127.0.0.1:" + std::to_string(implementation_->acceptor.local_endpoint().port());
}

void StreamServer::answer(bool yes) {
    const std::lock_guard lock(implementation_->mutex);
    implementation_->answers = yes;
}

void StreamServer::stall(bool yes) {
    const std::lock_guard lock(implementation_->mutex);
    implementation_->stalls = yes;
}

void StreamServer::refuse_with(int http_status) {
    const std::lock_guard lock(implementation_->mutex);
    implementation_->refusal = http_status;
}

void StreamServer::set_time(std::int64_t time_ms) {
    const std::lock_guard lock(implementation_->mutex);
    implementation_->time_ms = time_ms;
}

void StreamServer::refuse_kind(const std::string& kind) {
    const std::lock_guard lock(implementation_->mutex);
    implementation_->refused_kind = kind;
}

void StreamServer::cut() {
    const std::lock_guard lock(implementation_->mutex);
    if (implementation_->current >= 0) ::shutdown(implementation_->current, SHUT_RDWR);
}

void StreamServer::close_with(int code) {
    const std::lock_guard lock(implementation_->mutex);
    implementation_->close_code = code;
}

void StreamServer::send(const nlohmann::json& frame) {
    const std::lock_guard lock(implementation_->mutex);
    implementation_->outgoing.push_back(frame.dump());
}

int StreamServer::num_connections() const {
    const std::lock_guard lock(implementation_->mutex);
    return implementation_->num_connections;
}

std::vector<Heard> StreamServer::heard() const {
    const std::lock_guard lock(implementation_->mutex);
    return implementation_->heard;
}

bool StreamServer::wait_for(std::size_t num_messages, std::chrono::milliseconds time) const {
    std::unique_lock lock(implementation_->mutex);
    return implementation_->changed.wait_for(
        lock, time, [&] { return implementation_->heard.size() >= num_messages; });
}

bool StreamServer::wait_for_connections(int count, std::chrono::milliseconds time) const {
    std::unique_lock lock(implementation_->mutex);
    return implementation_->changed.wait_for(
        lock, time, [&] { return implementation_->num_connections >= count; });
}

}  // namespace divemesh::sensor
