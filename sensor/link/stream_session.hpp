#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "sensor/commands/command.hpp"
#include "sensor/link/connection.hpp"
#include "sensor/link/rate_meter.hpp"
#include "sensor/link/send_order.hpp"

namespace divemesh::sensor {

// The protocol on one connection: when a message may be sent, and what answers mean.
class StreamSession {
public:
    using Clock = std::chrono::steady_clock;
    using OnCommand = std::function<void(const Command& command)>;

    static constexpr std::size_t kMaxInFlight = 64;

    StreamSession(Connection& connection,
                  MessageRing& ring,
                  SendOrder& order,
                  RateMeter& rate,
                  std::int64_t asked_at_uptime_ms)
        : connection_(connection), ring_(ring), order_(order), rate_(rate) {
        order_.give_back();
        server_time_.asked_at_uptime_ms = asked_at_uptime_ms;
    }

    // Sends what may be sent now; `max_bytes_per_s` 0: no limit.
    void send(Clock::time_point now, double max_bytes_per_s);
    void receive(Clock::time_point now, const OnCommand& on_command);
    // Returns whether there has been no progress for too long, so the link is gone.
    bool is_dead(Clock::time_point now, std::chrono::milliseconds timeout);

    std::optional<ServerTime> server_time() const {
        return is_welcome_ ? std::optional(server_time_) : std::nullopt;
    }

private:
    struct Sent {
        std::int64_t num_bytes = 0;
        RateMeter::Stamp stamp;
    };

    bool may_send(std::size_t num_bytes, Clock::time_point now) const;
    bool send_next(Clock::time_point now, double max_bytes_per_s);
    void send_lost(Clock::time_point now);
    void put(std::string frame, bool is_binary, Clock::time_point now, double max_bytes_per_s);
    void welcome(const nlohmann::json& welcome);
    void answered(Clock::time_point now, const nlohmann::json& frame);
    void refused(const nlohmann::json& frame);
    Sent take_from_flight(MessageRing::Key key);

    Connection& connection_;
    MessageRing& ring_;
    SendOrder& order_;
    RateMeter& rate_;
    std::map<MessageRing::Key, Sent> in_flight_;
    std::int64_t in_flight_bytes_ = 0;
    std::map<std::string, std::vector<SequenceRange>> lost_in_flight_;  // by boot
    std::optional<std::pair<SendOrder::Next, Message>> prepared_;
    Clock::time_point free_at_ = {};  // by the rate limit
    Clock::time_point pinged_at_ = {};
    ServerTime server_time_;
    bool is_welcome_ = false;
};

}  // namespace divemesh::sensor
