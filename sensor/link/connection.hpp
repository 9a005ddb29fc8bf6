#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "api/client/rest_client.hpp"

namespace divemesh::sensor {

// The stream of one sensor (docs/sensors.md) for as long as it is up. Nothing in it waits longer
// than it is told to. One thread at a time.
class Connection {
public:
    using Clock = std::chrono::steady_clock;

    // Blocks for a few times `timeout` at most, and for the resolver where the server is named.
    // Throws Error{Unavailable} when there is no way to the server, and what its refusal means
    // otherwise: Unauthorized, Forbidden, NotFound, TooMany.
    Connection(const api::client::Account& account,
               const std::string& sensor_id,
               std::chrono::milliseconds timeout);
    ~Connection();

    void send_text(std::string frame);
    void send_binary(std::string frame);
    void ping();
    // Lets the network do its work until something happened or the time is over.
    void run(std::chrono::milliseconds time);
    // Says goodbye and waits for it no longer than that.
    void close(std::chrono::milliseconds time);

    std::vector<std::string> take_texts();  // that have come
    Clock::time_point heard_at() const;     // the last time that anything came
    Clock::time_point moved_at() const;     // ... or that the other end took bytes
    bool has_unsent() const;                // the other end has not taken all bytes

    bool is_open() const;
    int close_code() const;          // once it is not; 0: it was cut
    const std::string& why() const;  // for people

private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

}  // namespace divemesh::sensor
