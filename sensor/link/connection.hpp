#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "api/client/rest_client.hpp"

namespace divemesh::sensor {

// The open stream of one sensor (docs/sensors.md). No call blocks longer than its time limit. Use
// it from one thread at a time.
class Connection {
public:
    using Clock = std::chrono::steady_clock;

    // Blocks for a few times `timeout` at most, plus the resolver's time for a server's name.
    // Throws Error{Unavailable} if the server cannot be reached, otherwise the meaning of its
    // refusal: Unauthorized, Forbidden, NotFound, TooMany.
    Connection(const api::client::Account& account,
               const std::string& sensor_id,
               std::chrono::milliseconds timeout);
    ~Connection();

    void send_text(std::string frame);
    void send_binary(std::string frame);
    void ping();
    // Runs network operations until something happened or the time is over.
    void run(std::chrono::milliseconds time);
    // Closes the stream and waits for the other end for `time` at most.
    void close(std::chrono::milliseconds time);

    std::vector<std::string> take_texts();  // received ones
    Clock::time_point heard_at() const;     // the last time that bytes arrived
    Clock::time_point moved_at() const;     // the last time that bytes arrived or were taken
    bool has_unsent() const;                // the other end has not taken all bytes

    bool is_open() const;
    int close_code() const;          // after it closed; 0: it was cut
    const std::string& why() const;  // a readable reason

private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

}  // namespace divemesh::sensor
