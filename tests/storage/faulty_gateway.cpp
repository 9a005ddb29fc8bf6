#include "tests/storage/faulty_gateway.hpp"

#include <arpa/inet.h>
#include <chrono>
#include <netinet/in.h>
#include <poll.h>
#include <stdexcept>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/storage/s3_server.hpp"

namespace divemesh::storage {
namespace {

using namespace std::chrono_literals;
constexpr GatewayFault kNone{.num_times = 0};

sockaddr_in loopback(int port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return address;
}

FileDescriptor new_socket() {
    return FileDescriptor(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
}

// Returns "" at the end.
std::string receive(const FileDescriptor& socket) {
    std::string bytes(std::size_t{64} << 10, '\0');
    const auto n = recv(socket.get(), bytes.data(), bytes.size(), 0);
    bytes.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
    return bytes;
}

bool send_all(const FileDescriptor& socket, std::string_view bytes) {
    while (!bytes.empty()) {
        const auto n = send(socket.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
        if (n <= 0) return false;
        bytes.remove_prefix(static_cast<std::size_t>(n));
    }
    return true;
}

void reset(const FileDescriptor& socket) {
    const linger now{1, 0};
    setsockopt(socket.get(), SOL_SOCKET, SO_LINGER, &now, sizeof now);
}

std::size_t content_length(const std::string& head) {
    const std::string name = "\r\nContent-Length: ";
    const auto at = head.find(name);
    return at == std::string::npos ? 0 : std::stoul(head.substr(at + name.size()));
}

// Reads a whole request: head and body.
std::string receive_request(const FileDescriptor& client) {
    std::string request;
    std::size_t end = std::string::npos;
    while (end == std::string::npos || request.size() < end + 4 + content_length(request)) {
        const std::string bytes = receive(client);
        if (bytes.empty()) return "";
        request += bytes;
        end = request.find("\r\n\r\n");
    }
    return request;
}

}  // namespace

std::string refusal(int status, const std::string& code) {
    const std::string body =
        "<?xml version=\"1.0\"?><Error><Code>" + code + "</Code><Message>said so</Message></Error>";
    return "HTTP/1.1 " + std::to_string(status) +
           " No\r\nContent-Length: " + std::to_string(body.size()) +
           "\r\nContent-Type: application/xml\r\n\r\n" + body;
}

FaultyGateway::FaultyGateway(int target_port)
    : target_port_(target_port), port_(free_port()), listener_(new_socket()) {
    const sockaddr_in address = loopback(port_);
    const int yes = 1;
    setsockopt(listener_.get(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    if (bind(listener_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
        listen(listener_.get(), 64) != 0)
        throw std::runtime_error("the gateway cannot listen");
    acceptor_ = std::jthread([this] { accept_all(); });
}

FaultyGateway::~FaultyGateway() {
    ended_ = true;
    acceptor_.join();
    connections_.clear();
}

void FaultyGateway::make_fail(GatewayFault fault) {
    const std::lock_guard lock(mutex_);
    faults_.push_back(std::move(fault));
}

std::vector<std::string> FaultyGateway::requests() const {
    const std::lock_guard lock(mutex_);
    return requests_;
}

void FaultyGateway::accept_all() {
    while (!ended_) {
        pollfd waiting{listener_.get(), POLLIN, 0};
        if (poll(&waiting, 1, 50) != 1) continue;
        FileDescriptor client(accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC));
        if (!client.is_open()) continue;
        connections_.emplace_back([this, taken = std::move(client)] { serve(taken); });
    }
}

GatewayFault FaultyGateway::take_fault(const std::string& first_line) {
    const std::lock_guard lock(mutex_);
    requests_.push_back(first_line);
    for (GatewayFault& fault : faults_) {
        const bool fits = first_line.starts_with(fault.method + ' ') &&
                          first_line.find(fault.target) != std::string::npos;
        if (!fits || fault.num_times == 0) continue;
        --fault.num_times;
        ++num_faults_;
        GatewayFault taken = fault;
        taken.num_times = 1;
        return taken;
    }
    return kNone;
}

void FaultyGateway::serve(const FileDescriptor& client) {
    const std::string request = receive_request(client);
    if (request.empty()) return;
    num_bytes_sent_ += static_cast<std::int64_t>(content_length(request));
    const GatewayFault fault = take_fault(request.substr(0, request.find("\r\n")));
    if (fault.num_times == 0) return pass_on(client, request, Trouble::Answer);
    switch (fault.trouble) {
        case Trouble::Answer: send_all(client, fault.answer); break;
        case Trouble::Reset: reset(client); break;
        case Trouble::Silence:
            for (int i = 0; i < 60 && !ended_; ++i) std::this_thread::sleep_for(50ms);
            break;
        case Trouble::HalfAnswer:
        case Trouble::LostAnswer: pass_on(client, request, fault.trouble);
    }
}

void FaultyGateway::pass_on(const FileDescriptor& client,
                            const std::string& request,
                            Trouble trouble) {
    const FileDescriptor target = new_socket();
    const sockaddr_in address = loopback(target_port_);
    if (connect(target.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
        return reset(client);
    std::string once = request;
    once.insert(once.find("\r\n"), "\r\nConnection: close");
    if (!send_all(target, once)) return reset(client);
    std::string answer;
    for (std::string bytes = receive(target); !bytes.empty(); bytes = receive(target))
        answer += bytes;
    num_bytes_received_ += static_cast<std::int64_t>(answer.size());
    if (trouble == Trouble::LostAnswer) return reset(client);
    if (trouble == Trouble::HalfAnswer) {
        const auto body = answer.find("\r\n\r\n") + 4;
        answer.resize(body + (answer.size() - body) / 2);
    }
    send_all(client, answer);
}

}  // namespace divemesh::storage
