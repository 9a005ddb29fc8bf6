#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace divemesh::sensor {

// A message as it came to the server.
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

// The server's side of a sensor's stream, which a test tells how to behave. Loopback; a thread for
// each connection, all of which end with it.
class StreamServer {
public:
    StreamServer();
    ~StreamServer();
    StreamServer(const StreamServer&) = delete;
    StreamServer& operator=(const StreamServer&) = delete;

    std::string url() const;
    void answer(bool yes);                // else it reads and says nothing; true at first
    void stall(bool yes);                 // reads nothing, not even pings
    void refuse_with(int http_status);    // handshakes; 0: no more
    void set_time(std::int64_t time_ms);  // that the next welcome tells
    void refuse_kind(const std::string& kind);
    void cut();  // the connection that is there
    void close_with(int code);
    void send(const nlohmann::json& frame);

    int num_connections() const;  // that were asked for
    std::vector<Heard> heard() const;
    // Waits for so many messages; false: they did not come in time.
    bool wait_for(std::size_t num_messages,
                  std::chrono::milliseconds time = std::chrono::seconds(10)) const;
    bool wait_for_connections(int count,
                              std::chrono::milliseconds time = std::chrono::seconds(10)) const;

private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

}  // namespace divemesh::sensor
