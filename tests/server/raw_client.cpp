#include "tests/server/raw_client.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <openssl/evp.h>
#include <stdexcept>
#include <sys/socket.h>

#include "tests/server/contract.hpp"

namespace divemesh {

std::string RawResponse::header(const std::string& name) const {
    const auto found = headers.find(name);
    return found == headers.end() ? "" : found->second;
}

RawClient::RawClient(int port, int receive_buffer_bytes)
    : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    const timeval timeout{20, 0};
    setsockopt(socket_.get(), SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof timeout);
    setsockopt(socket_.get(), SOL_SOCKET, SO_SNDTIMEO, &timeout, sizeof timeout);
    if (receive_buffer_bytes > 0)
        setsockopt(socket_.get(),
                   SOL_SOCKET,
                   SO_RCVBUF,
                   &receive_buffer_bytes,
                   sizeof receive_buffer_bytes);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (connect(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
        throw std::runtime_error("cannot connect");
}

bool RawClient::send(std::string_view bytes) {
    while (!bytes.empty()) {
        const auto n = ::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
        if (n <= 0) return false;
        bytes.remove_prefix(static_cast<std::size_t>(n));
    }
    return true;
}

std::string RawClient::read_available() {
    char buffer[1 << 16];
    const auto n = recv(socket_.get(), buffer, sizeof buffer, 0);
    return n <= 0 ? std::string() : std::string(buffer, static_cast<std::size_t>(n));
}

bool RawClient::at_end() { return received_.empty() && read_available().empty(); }

void RawClient::reset() {
    const linger read_nonblocking{1, 0};
    setsockopt(socket_.get(), SOL_SOCKET, SO_LINGER, &read_nonblocking, sizeof read_nonblocking);
    socket_.close();
}

std::optional<RawResponse> RawClient::receive(bool head) {
    auto response = receive_one(head);
    while (response && response->status == 100) response = receive_one(head);
    return response;
}

std::optional<RawResponse> RawClient::receive_one(bool head) {
    std::size_t end = std::string::npos;
    while ((end = received_.find("\r\n\r\n")) == std::string::npos) {
        const std::string more = read_available();
        if (more.empty()) return std::nullopt;
        received_ += more;
    }
    RawResponse response;
    response.status = std::stoi(received_.substr(9, 3));
    for (std::size_t line = received_.find("\r\n") + 2; line < end;) {
        const auto line_end = received_.find("\r\n", line);
        const auto colon = received_.find(": ", line);
        std::string name = received_.substr(line, colon - line);
        std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) {
            return static_cast<char>(std::tolower(c));
        });
        response.headers[name] = received_.substr(colon + 2, line_end - colon - 2);
        line = line_end + 2;
    }
    received_.erase(0, end + 4);
    if (response.header("transfer-encoding") == "chunked" && !head) {
        auto body = receive_chunks();
        if (!body) return std::nullopt;
        response.body = std::move(*body);
        return response;
    }
    const std::string length = response.header("content-length");
    const std::size_t size = head || length.empty() ? 0 : std::stoul(length);
    if (!receive_bytes(size)) return std::nullopt;
    response.body = received_.substr(0, size);
    received_.erase(0, size);
    return response;
}

bool RawClient::receive_bytes(std::size_t size) {
    while (received_.size() < size) {
        const std::string more = read_available();
        if (more.empty()) return false;
        received_ += more;
    }
    return true;
}

// Without extensions and trailers, which the server does not send.
std::optional<std::string> RawClient::receive_chunks() {
    std::string body;
    for (;;) {
        std::size_t end = std::string::npos;
        while ((end = received_.find("\r\n")) == std::string::npos)
            if (!receive_bytes(received_.size() + 1)) return std::nullopt;
        const std::size_t size = std::stoul(received_.substr(0, end), nullptr, 16);
        if (!receive_bytes(end + 2 + size + 2)) return std::nullopt;
        body += received_.substr(end + 2, size);
        received_.erase(0, end + 2 + size + 2);
        if (size == 0) return body;
    }
}

// What the server takes it for (tus 1.0).
std::string effective_method(const std::string& method, const Headers& headers) {
    for (const auto& [name, value] : headers)
        if (name == "X-HTTP-Method-Override" && method == "POST") return value;
    return method;
}

RawResponse RawClient::request(const std::string& method,
                               const std::string& target,
                               const Headers& headers,
                               std::string_view body) {
    const bool has_body = !body.empty() || method == "POST" || method == "PATCH" || method == "PUT";
    const auto length = has_body ? std::optional(body.size()) : std::nullopt;
    send(request_head(method, target, headers, length));
    send(body);  // may fail when the answer came first: that is then read
    auto response = receive(method == "HEAD");
    if (!response) throw std::runtime_error("no answer to " + method + " " + target);
    const std::string breach =
        contract_breach(effective_method(method, headers), target, *response);
    EXPECT_EQ(breach, "") << method << ' ' << target << " -> " << response->status << ' '
                          << response->body.substr(0, 1000);
    return std::move(*response);
}

std::string request_head(const std::string& method,
                         const std::string& target,
                         const Headers& headers,
                         std::optional<std::size_t> content_length) {
    std::string text = method + " " + target + " HTTP/1.1\r\nHost: 127.0.0.1\r\n";
    for (const auto& [name, value] : headers) text += name + ": " + value + "\r\n";
    if (content_length) text += "Content-Length: " + std::to_string(*content_length) + "\r\n";
    return text + "\r\n";
}

std::string base64(std::string_view bytes) {
    std::string text(4 * ((bytes.size() + 2) / 3) + 1, '\0');
    const int size = EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()),
                                     reinterpret_cast<const unsigned char*>(bytes.data()),
                                     static_cast<int>(bytes.size()));
    text.resize(static_cast<std::size_t>(size));
    return text;
}

}  // namespace divemesh
