#pragma once

#include <atomic>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "schemas/file_descriptor.hpp"

namespace divemesh::storage {

// What goes wrong with a request instead of its being answered.
enum class Trouble {
    Answer,      // another answer comes
    Reset,       // the connection is reset
    Silence,     // nothing comes, for three seconds
    HalfAnswer,  // the true answer ends in its middle
    LostAnswer,  // the request is done, and the connection is reset
};

struct GatewayFault {
    std::string method;
    std::string target;  // a part of the request's path and query; "" is in all
    Trouble trouble = Trouble::Answer;
    std::string answer = {};  // with its headers
    int num_times = 1;
};

// Returns an answer of HTTP as an object store gives it when it refuses.
std::string refusal(int status, const std::string& code);

// Passes requests on to an object store on loopback, one a connection, and makes the wanted ones
// fail.
class FaultyGateway {
public:
    explicit FaultyGateway(int target_port);
    ~FaultyGateway();
    FaultyGateway(const FaultyGateway&) = delete;
    FaultyGateway& operator=(const FaultyGateway&) = delete;

    void make_fail(GatewayFault fault);
    int port() const { return port_; }
    int num_faults() const { return num_faults_; }                           // that have happened
    std::int64_t num_bytes_sent() const { return num_bytes_sent_; }          // of requests' bodies
    std::int64_t num_bytes_received() const { return num_bytes_received_; }  // of answers
    std::vector<std::string> requests() const;                               // first lines

private:
    void accept_all();
    void serve(const FileDescriptor& client);
    GatewayFault take_fault(const std::string& first_line);
    void pass_on(const FileDescriptor& client, const std::string& request, Trouble trouble);

    int target_port_;
    int port_ = 0;
    FileDescriptor listener_;
    mutable std::mutex mutex_;
    std::vector<GatewayFault> faults_;
    std::vector<std::string> requests_;
    std::vector<std::jthread> connections_;
    std::atomic<int> num_faults_ = 0;
    std::atomic<std::int64_t> num_bytes_sent_ = 0;
    std::atomic<std::int64_t> num_bytes_received_ = 0;
    std::atomic<bool> ended_ = false;
    std::jthread acceptor_;
};

}  // namespace divemesh::storage
