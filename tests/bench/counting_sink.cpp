#include "tests/bench/counting_sink.hpp"

#include <arpa/inet.h>
#include <poll.h>
#include <stdexcept>
#include <string>
#include <sys/socket.h>
#include <vector>

namespace divemesh::bench {
namespace {

constexpr std::size_t kChunkBytes = std::size_t{256} << 10;

std::size_t content_length(const std::string& header) {
    const auto at = header.find("Content-Length: ");
    return at == std::string::npos ? 0 : std::stoul(header.substr(at + 16));
}

void answer_all(int socket) {
    std::vector<char> piece(kChunkBytes);
    std::string header;
    for (;;) {
        const auto n = recv(socket, piece.data(), piece.size(), 0);
        if (n <= 0) return;
        header.append(piece.data(), static_cast<std::size_t>(n));
        const auto end = header.find("\r\n\r\n");
        if (end == std::string::npos) continue;
        std::size_t seen = header.size() - end - 4;
        for (const std::size_t length = content_length(header); seen < length;) {
            const auto more = recv(socket, piece.data(), piece.size(), 0);
            if (more <= 0) return;
            seen += static_cast<std::size_t>(more);
        }
        const std::string answer = header.starts_with("POST")
                                       ? "HTTP/1.1 201 Created\r\nLocation: /api/v1/uploads/x\r\n"
                                         "Content-Length: 0\r\n\r\n"
                                       : "HTTP/1.1 204 No Content\r\n\r\n";
        if (send(socket, answer.data(), answer.size(), MSG_NOSIGNAL) <= 0) return;
        header.clear();
    }
}

}  // namespace

CountingSink::CountingSink() : listener_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    if (bind(listener_.get(), reinterpret_cast<sockaddr*>(&address), size) != 0 ||
        listen(listener_.get(), 8) != 0 ||
        getsockname(listener_.get(), reinterpret_cast<sockaddr*>(&address), &size) != 0)
        throw std::runtime_error("cannot listen");
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] { serve(); });
}

CountingSink::~CountingSink() {
    stop_ = true;
    thread_.join();
}

void CountingSink::serve() {
    while (!stop_) {
        pollfd waiting{listener_.get(), POLLIN, 0};
        if (poll(&waiting, 1, 20) <= 0) continue;
        const FileDescriptor socket(accept(listener_.get(), nullptr, nullptr));
        answer_all(socket.get());
    }
}

}  // namespace divemesh::bench
