#include "tests/api/client/fake_tus_server.hpp"

#include <algorithm>
#include <arpa/inet.h>
#include <array>
#include <poll.h>
#include <stdexcept>
#include <sys/socket.h>

namespace divemesh {
namespace {

std::string header_value(const std::string& header, const std::string& name) {
    const std::size_t at = header.find("\r\n" + name + ": ");
    if (at == std::string::npos) return "";
    const std::size_t start = at + name.size() + 4;
    return header.substr(start, header.find("\r\n", start) - start);
}

void send_text(int socket, const std::string& text) {
    ::send(socket, text.data(), text.size(), MSG_NOSIGNAL);
}

void answer(int socket, int status, const std::string& headers = "") {
    send_text(socket,
              "HTTP/1.1 " + std::to_string(status) + " x\r\nTus-Resumable: 1.0.0\r\n" + headers +
                  (status == 204 ? "" : "Content-Length: 0\r\n") + "\r\n");
}

}  // namespace

FakeTusServer::FakeTusServer() : listener_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    auto* raw = reinterpret_cast<sockaddr*>(&address);
    if (::bind(listener_.get(), raw, size) != 0 || ::listen(listener_.get(), 8) != 0 ||
        ::getsockname(listener_.get(), raw, &size) != 0)
        throw std::runtime_error("cannot listen on loopback");
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] { serve(); });
}

FakeTusServer::~FakeTusServer() {
    stop_ = true;
    thread_.join();
}

std::string FakeTusServer::url() const { return "http://127.0.0.1:" + std::to_string(port_); }

void FakeTusServer::script_patches(std::deque<Fault> faults) {
    const std::lock_guard lock(mutex_);
    faults_ = std::move(faults);
}

void FakeTusServer::forget_upload() {
    const std::lock_guard lock(mutex_);
    known_ = false;
}

std::string FakeTusServer::stored() {
    const std::lock_guard lock(mutex_);
    return stored_;
}

std::string FakeTusServer::last_metadata() {
    const std::lock_guard lock(mutex_);
    return metadata_;
}

std::int64_t FakeTusServer::body_bytes_received() {
    const std::lock_guard lock(mutex_);
    return body_bytes_;
}

int FakeTusServer::num_created() {
    const std::lock_guard lock(mutex_);
    return num_created_;
}

void FakeTusServer::serve() {
    while (!stop_) {
        pollfd waiting{listener_.get(), POLLIN, 0};
        if (::poll(&waiting, 1, 20) <= 0) continue;
        const FileDescriptor socket(::accept(listener_.get(), nullptr, nullptr));
        serve_connection(socket.get());
    }
}

void FakeTusServer::serve_connection(int socket) {
    std::string pending;
    std::array<char, 65536> buffer{};
    while (!stop_) {
        if (pending.find("\r\n\r\n") != std::string::npos) {
            if (!serve_request(socket, pending)) return;
            continue;
        }
        pollfd waiting{socket, POLLIN, 0};
        if (::poll(&waiting, 1, 20) <= 0) {
            pollfd next{listener_.get(), POLLIN, 0};  // the client has reconnected
            if (::poll(&next, 1, 0) > 0) return;
            continue;
        }
        const ssize_t count = ::recv(socket, buffer.data(), buffer.size(), 0);
        if (count <= 0) return;
        pending.append(buffer.data(), static_cast<std::size_t>(count));
    }
}

bool FakeTusServer::serve_request(int socket, std::string& pending) {
    const std::size_t end = pending.find("\r\n\r\n") + 4;
    const std::string header = pending.substr(0, end);
    pending.erase(0, end);
    if (header.starts_with("PATCH")) return patch(socket, header, pending);
    const std::lock_guard lock(mutex_);
    if (header.starts_with("POST")) {
        stored_.clear();
        length_ = std::stoll(header_value(header, "Upload-Length"));
        metadata_ = header_value(header, "Upload-Metadata");
        known_ = true;
        ++num_created_;
        answer(socket, 201, "Location: /api/v1/uploads/u" + std::to_string(num_created_) + "\r\n");
    } else if (!known_) {
        answer(socket, 404);
    } else {
        answer(socket,
               200,
               "Upload-Offset: " + std::to_string(stored_.size()) +
                   "\r\nUpload-Length: " + std::to_string(length_) + "\r\n");
    }
    return true;
}

bool FakeTusServer::patch(int socket, const std::string& header, std::string& pending) {
    Fault fault;
    {
        const std::lock_guard lock(mutex_);
        if (!faults_.empty()) {
            fault = faults_.front();
            faults_.pop_front();
        }
    }
    if (fault.status > 0) {
        const std::string type = fault.by_proxy ? "text/html" : "application/problem+json";
        answer(socket, fault.status, "Connection: close\r\nContent-Type: " + type + "\r\n");
        return false;
    }
    const std::int64_t length = std::stoll(header_value(header, "Content-Length"));
    const std::int64_t wanted = fault.cut_after >= 0 ? std::min(length, fault.cut_after) : length;
    std::array<char, 65536> buffer{};
    while (static_cast<std::int64_t>(pending.size()) < wanted) {
        const ssize_t count = ::recv(socket, buffer.data(), buffer.size(), 0);
        if (count <= 0) return false;
        pending.append(buffer.data(), static_cast<std::size_t>(count));
    }
    std::int64_t offset = 0;
    {
        const std::lock_guard lock(mutex_);
        if (header_value(header, "Upload-Offset") != std::to_string(stored_.size())) {
            answer(socket, 409, "Connection: close\r\n");
            return false;
        }
        stored_.append(pending, 0, static_cast<std::size_t>(wanted));
        body_bytes_ += wanted;
        offset = static_cast<std::int64_t>(stored_.size());
    }
    pending.erase(0, static_cast<std::size_t>(wanted));
    if (wanted < length) return false;
    if (fault.silent) {
        while (!stop_) {
            pollfd next{listener_.get(), POLLIN, 0};
            if (::poll(&next, 1, 20) > 0) return false;
        }
        return false;
    }
    answer(socket, 204, "Upload-Offset: " + std::to_string(offset) + "\r\n");
    return true;
}

}  // namespace divemesh
