#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace divemesh::sensor {

// A message that the server received.
struct Heard {
    int connection = 0;  // the first is 0
    std::string kind;    // "hello", "status", "preview", "outcome", "lost"
    std::string boot_id;
    std::int64_t sequence = 0;
    bool is_historical = false;
    std::size_t num_bytes = 0;
    std::chrono::steady_clock::time_point at;
    nlohmann::json body;
};

// The server's side of a sensor's stream on loopback, controlled by a test. It has a thread for
// each connection; the destructor ends them all.
class StreamServer {
public:
    StreamServer();
    ~StreamServer();
    StreamServer(const StreamServer&) = delete;
    StreamServer& operator=(const StreamServer&) = delete;

    std::string url() const;
    void answer(bool yes);                      // false: reads messages without an answer
    void stall(bool yes);                       // true: reads nothing, not even pings
    void refuse_with(int http_status);          // the status of handshakes; 0: accepts them
    void set_time(std::int64_t time_ms);        // of the next welcome
    void refuse_kind(const std::string& kind);  // answers messages of this kind with 400
    void cut();                                 // shuts the current connection down
    void close_with(int code);                  // closes the current stream with this code
    void send(const nlohmann::json& frame);

    int num_connections() const;  // TCP connections accepted until now
    std::vector<Heard> heard() const;
    // Waits until `num_messages` have arrived in all; false if they do not arrive in time.
    bool wait_for(std::size_t num_messages,
                  std::chrono::milliseconds time = std::chrono::seconds(10)) const;
    bool wait_for_connections(int count,
                              std::chrono::milliseconds time = std::chrono::seconds(10)) const;

private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

}  // namespace divemesh::sensor
