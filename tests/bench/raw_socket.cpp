#include "tests/bench/raw_socket.hpp"

#include <arpa/inet.h>
#include <stdexcept>
#include <sys/socket.h>

namespace divemesh {

FileDescriptor connect_to(int port, int receive_buffer_bytes) {
    FileDescriptor socket(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    if (receive_buffer_bytes > 0)
        setsockopt(socket.get(),
                   SOL_SOCKET,
                   SO_RCVBUF,
                   &receive_buffer_bytes,
                   sizeof receive_buffer_bytes);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (connect(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
        throw std::runtime_error("cannot connect");
    return socket;
}

int free_port() {
    const FileDescriptor socket(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof address;
    const bool is_bound =
        bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
        getsockname(socket.get(), reinterpret_cast<sockaddr*>(&address), &length) == 0;
    if (!is_bound) throw std::runtime_error("no port is free");
    return ntohs(address.sin_port);
}

void send_all(int socket, std::string_view bytes) {
    while (!bytes.empty()) {
        const auto n = send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
        if (n <= 0) throw std::runtime_error("the server closed a connection");
        bytes.remove_prefix(static_cast<std::size_t>(n));
    }
}

std::string receive_head(int socket) {
    std::string text;
    for (char c = 0; text.find("\r\n\r\n") == std::string::npos && recv(socket, &c, 1, 0) == 1;)
        text += c;
    return text;
}

void open_web_socket(int socket, const std::string& target, const std::string& token) {
    send_all(socket,
             "GET " + target +
                 " HTTP/1.1\r\nHost: x\r\nUpgrade: websocket\r\n"
                 "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                 "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nAuthorization: Bearer " +
                 token + "\r\n\r\n");
    if (!receive_head(socket).starts_with("HTTP/1.1 101"))
        throw std::runtime_error("the server opened no WebSocket");
}

}  // namespace divemesh
