#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "api/client/rest_client.hpp"
#include "sensor/commands/command.hpp"
#include "sensor/link/rate_meter.hpp"
#include "sensor/link/send_order.hpp"
#include "sensor/ring/message_ring.hpp"

namespace divemesh::sensor {

struct LinkSettings {
    double max_bytes_per_s = 0.0;                      // 0: no limit
    std::chrono::milliseconds connect_timeout{1'500};  // of each step of connecting
    std::chrono::milliseconds pause{250};              // between tries while there is no link
    std::chrono::milliseconds timeout{3'000};          // without progress while bytes wait
    std::chrono::milliseconds refused_pause{30'000};   // after the server refused the connection
    std::function<void(const std::string& what)> on_event;  // readable; on the link's thread
};

// The state of the link, for the status.
struct LinkState {
    bool is_connected = false;
    double bytes_per_s = 0.0;  // as measured; 0: unknown
    std::string trouble;       // why it is not connected; "": no problem
    std::optional<ServerTime> server_time;
};

// Sends the messages of the ring to the server while it can be reached, in the order of SendOrder,
// and resumes when the connection is back. It has its own thread; the destructor ends it within a
// second or two.
class Link {
public:
    // Throws Error{InvalidArgument} for an invalid server address.
    Link(api::client::Account account,
         std::string sensor_id,
         MessageRing& ring,
         LinkSettings settings);
    ~Link();
    Link(const Link&) = delete;
    Link& operator=(const Link&) = delete;

    LinkState state() const;
    std::vector<Command> take_commands();  // received ones; one may occur twice

private:
    void run(const std::stop_token& stop);
    // Returns how long to wait before the next try.
    std::chrono::milliseconds try_once(const std::stop_token& stop);
    std::chrono::milliseconds serve(const std::stop_token& stop);
    void tell(bool is_connected, const std::string& trouble);

    api::client::Account account_;
    std::string sensor_id_;
    MessageRing& ring_;
    LinkSettings settings_;
    SendOrder order_{ring_};  // like rate_, for the thread only
    RateMeter rate_;
    mutable std::mutex mutex_;
    LinkState state_;
    std::vector<Command> commands_;
    std::jthread thread_;  // last: it uses the others
};

}  // namespace divemesh::sensor
