#pragma once

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <sys/socket.h>

namespace divemesh {

// A blocking WebSocket client of Beast. Throws if a read takes longer than 20 s.
class WebSocketClient {
public:
    WebSocketClient(int port, const std::string& token, const std::string& target) {
        boost::asio::connect(
            socket_.next_layer(),
            boost::asio::ip::tcp::resolver(context_).resolve("127.0.0.1", std::to_string(port)));
        const timeval timeout{20, 0};
        setsockopt(socket_.next_layer().native_handle(),
                   SOL_SOCKET,
                   SO_RCVTIMEO,
                   &timeout,
                   sizeof timeout);
        socket_.read_message_max(std::size_t{16} << 20);
        socket_.set_option(boost::beast::websocket::stream_base::decorator(
            [token](boost::beast::websocket::request_type& request) {
                if (!token.empty())
                    request.set(boost::beast::http::field::authorization, "Bearer " + token);
            }));
        socket_.handshake("127.0.0.1", target);
    }

    nlohmann::json next_json() {
        boost::beast::flat_buffer buffer;
        socket_.read(buffer);
        return nlohmann::json::parse(boost::beast::buffers_to_string(buffer.data()));
    }
    void say_text(const std::string& text) {
        socket_.text(true);
        socket_.write(boost::asio::buffer(text));
    }
    void say(const nlohmann::json& frame) { say_text(frame.dump()); }
    void say_bytes(const std::string& bytes) {
        socket_.binary(true);
        socket_.write(boost::asio::buffer(bytes));
    }
    unsigned close_code() {  // reads until the server closes
        boost::beast::error_code error;
        for (boost::beast::flat_buffer buffer; !error;) socket_.read(buffer, error);
        return socket_.reason().code;
    }
    std::string close_reason() const { return socket_.reason().reason.c_str(); }  // after that

private:
    boost::asio::io_context context_;
    boost::beast::websocket::stream<boost::asio::ip::tcp::socket> socket_{context_};
};

}  // namespace divemesh
