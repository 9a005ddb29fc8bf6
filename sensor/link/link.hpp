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
    double max_bytes_per_s = 0.0;                      // 0: as fast as it goes
    std::chrono::milliseconds connect_timeout{1'500};  // of each step of connecting
    std::chrono::milliseconds pause{250};              // between tries while there is no link
    std::chrono::milliseconds timeout{3'000};          // with bytes unanswered and nothing moving
    std::chrono::milliseconds refused_pause{30'000};   // when the server does not want us
    std::function<void(const std::string& what)> on_event;  // for people; on the link's thread
};

struct LinkState {
    bool is_connected = false;
    double bytes_per_s = 0.0;  // as measured; 0: not known
    std::string trouble;       // why it is not; "": nothing is wrong
    std::optional<ServerTime> server_time;
};

// Hands what is in the ring to the server, as long as there is a way to it, in the order of
// SendOrder, and goes on where it was when the way is back. A thread of its own; the destructor
// ends it within a second or two.
class Link {
public:
    // Throws Error{InvalidArgument} for a server that cannot be addressed.
    Link(api::client::Account account,
         std::string sensor_id,
         MessageRing& ring,
         LinkSettings settings);
    ~Link();
    Link(const Link&) = delete;
    Link& operator=(const Link&) = delete;

    LinkState state() const;
    std::vector<Command> take_commands();  // that have come; one may come twice

private:
    void run(const std::stop_token& stop);
    // How long to wait before the next one.
    std::chrono::milliseconds try_once(const std::stop_token& stop);
    std::chrono::milliseconds serve(const std::stop_token& stop);
    void tell(bool is_connected, const std::string& trouble);

    api::client::Account account_;
    std::string sensor_id_;
    MessageRing& ring_;
    LinkSettings settings_;
    SendOrder order_{ring_};  // with rate_, of the thread alone
    RateMeter rate_;
    mutable std::mutex mutex_;
    LinkState state_;
    std::vector<Command> commands_;
    std::jthread thread_;  // last: it uses the others
};

}  // namespace divemesh::sensor
