#include "sensor/link/stream_session.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "sensor/clock/uptime.hpp"

namespace divemesh::sensor {
namespace {

using nlohmann::json;

// Used while a link's rate is unknown, and on the slowest link.
constexpr double kMinWindowBytes = 4096.0;
constexpr double kMinRate_bytes_per_s = 2048.0;  // assumed for any link
constexpr double kMaxTimeout_s = 30.0;
constexpr std::chrono::seconds kPingIdleAfter{10};

bool is_range(const json& range) {
    return range.is_array() && range.size() == 2 && range[0].is_number_integer() &&
           range[1].is_number_integer();
}

}  // namespace

void StreamSession::send(Clock::time_point now, double max_bytes_per_s) {
    if (!is_welcome_) return;
    while (send_next(now, max_bytes_per_s)) continue;
    const auto next = order_.next();
    if (!next || next->is_historical) send_lost(now);  // current messages come first
}

bool StreamSession::may_send(std::size_t num_bytes, Clock::time_point now) const {
    if (in_flight_.empty()) return true;  // of any size
    const double window = std::max(kMinWindowBytes, rate_.bytes_per_s(now));
    return static_cast<double>(in_flight_bytes_) + static_cast<double>(num_bytes) <= window;
}

bool StreamSession::send_next(Clock::time_point now, double max_bytes_per_s) {
    if (now < free_at_ || in_flight_.size() >= kMaxInFlight || !connection_.is_open()) return false;
    const auto next = order_.next();
    if (!next) return false;
    if (!prepared_ || prepared_->first.key != next->key) {
        auto message = ring_.read(next->key);
        if (!message) return true;  // it is lost, which is sent next
        prepared_.emplace(*next, std::move(*message));
    }
    const Message& message = prepared_->second;
    if (!may_send(message.body.size() + message.jpeg.size(), now)) return false;
    std::string frame = frame_of(message, next->is_historical);
    const auto stamp = rate_.sent(now, in_flight_.empty());
    in_flight_.emplace(next->key, Sent{static_cast<std::int64_t>(frame.size()), stamp});
    in_flight_bytes_ += static_cast<std::int64_t>(frame.size());
    order_.sent(next->key, message.kind);
    put(std::move(frame), message.kind == MessageKind::Preview, now, max_bytes_per_s);
    prepared_.reset();
    return true;
}

void StreamSession::put(std::string frame,
                        bool is_binary,
                        Clock::time_point now,
                        double max_bytes_per_s) {
    if (max_bytes_per_s > 0.0) {
        const std::chrono::duration<double> takes(static_cast<double>(frame.size()) /
                                                  max_bytes_per_s);
        free_at_ = std::max(free_at_, now) + std::chrono::duration_cast<Clock::duration>(takes);
    }
    if (is_binary)
        connection_.send_binary(std::move(frame));
    else
        connection_.send_text(std::move(frame));
}

// Reports the losses of one boot at a time, once the server has acknowledged those before.
void StreamSession::send_lost(Clock::time_point now) {
    if (!lost_in_flight_.empty()) return;
    const auto lost = ring_.lost();
    if (!lost) return;
    put(lost_frame(lost->boot_id, lost->ranges), false, now, 0.0);
    lost_in_flight_[lost->boot_id] = lost->ranges;
}

void StreamSession::receive(Clock::time_point now, const OnCommand& on_command) {
    for (const std::string& text : connection_.take_texts()) {
        const json frame = json::parse(text, nullptr, false);
        if (!frame.is_object()) continue;
        if (frame.contains("welcome")) welcome(frame["welcome"]);
        if (frame.contains("answer")) answered(now, frame);
        if (frame.contains("refused")) refused(frame);
        if (!frame.contains("command")) continue;
        auto command = command_of(frame["command"]);
        if (!command || !is_welcome_) continue;
        command->server_time = server_time_;
        on_command(*command);
    }
}

void StreamSession::welcome(const json& welcome) {
    if (!welcome.is_object() || !welcome.contains("time_ms") ||
        !welcome["time_ms"].is_number_integer())
        return;
    server_time_.time_ms = welcome["time_ms"].get<std::int64_t>();
    server_time_.heard_at_uptime_ms = uptime_ms();
    is_welcome_ = true;
}

void StreamSession::answered(Clock::time_point now, const json& frame) {
    const json& answer = frame["answer"];
    const auto boot = answer.is_object() ? answer.find("boot_id") : answer.end();
    const auto ranges = frame.find("committed");
    if (boot == answer.end() || !boot->is_string() || ranges == frame.end() || !ranges->is_array())
        return;
    const std::string boot_id = boot->get<std::string>();
    std::int64_t num_bytes = 0;
    RateMeter::Stamp last;
    for (const json& range : *ranges) {
        if (!is_range(range)) continue;
        const SequenceRange committed{range[0].get<std::int64_t>(), range[1].get<std::int64_t>()};
        std::vector<MessageRing::Key> keys;
        for (const auto& [key, sent] : in_flight_)
            if (key.sequence >= committed.first && key.sequence <= committed.last &&
                ring_.boot_id(key) == boot_id)
                keys.push_back(key);
        for (const auto& key : keys) {
            order_.committed(key);
            const Sent sent = take_from_flight(key);
            num_bytes += sent.num_bytes;
            if (sent.stamp.at >= last.at) last = sent.stamp;
        }
        ring_.committed(boot_id, committed);
    }
    if (num_bytes > 0) rate_.answered(now, last, num_bytes);
    if (const auto lost = lost_in_flight_.find(boot_id); lost != lost_in_flight_.end()) {
        ring_.reported_lost(boot_id, lost->second);
        lost_in_flight_.erase(lost);
    }
}

StreamSession::Sent StreamSession::take_from_flight(MessageRing::Key key) {
    const auto found = in_flight_.find(key);
    const Sent sent = found->second;
    in_flight_bytes_ -= sent.num_bytes;
    in_flight_.erase(found);
    return sent;
}

// If the server could not read a frame, its answer does not say which boot it was. Then it is the
// newest boot that has such a message under way.
void StreamSession::refused(const json& frame) {
    const auto sequences = frame.find("messages");
    if (sequences == frame.end() || !sequences->is_array()) return;
    const auto boot = frame.find("boot_id");
    const std::string boot_id =
        boot != frame.end() && boot->is_string() ? boot->get<std::string>() : "";
    for (const json& sequence : *sequences) {
        if (!sequence.is_number_integer()) continue;
        const auto is_meant = [&](const auto& sent) {
            return sent.first.sequence == sequence.template get<std::int64_t>() &&
                   (boot_id.empty() || ring_.boot_id(sent.first) == boot_id);
        };
        const auto meant = std::find_if(in_flight_.rbegin(), in_flight_.rend(), is_meant);
        if (meant == in_flight_.rend()) continue;
        const MessageRing::Key key = meant->first;
        order_.refused(key);
        take_from_flight(key);
        ring_.refused(key);
    }
}

bool StreamSession::is_dead(Clock::time_point now, std::chrono::milliseconds timeout) {
    const bool is_waiting = !in_flight_.empty() || !lost_in_flight_.empty() || !is_welcome_;
    const auto quiet = now - connection_.moved_at();
    const auto ping_after =
        is_waiting ? Clock::duration(timeout) / 3 : Clock::duration(kPingIdleAfter);
    if (quiet > ping_after && now > pinged_at_ + ping_after) {
        connection_.ping();
        pinged_at_ = now;
    }
    // A ping waits behind the bytes that were sent before it.
    const double rate = std::max(rate_.bytes_per_s(now), kMinRate_bytes_per_s);
    const std::chrono::duration<double> on_the_way(
        std::min(kMaxTimeout_s, 1.5 * static_cast<double>(in_flight_bytes_) / rate));
    auto longest = Clock::duration(timeout);
    if (!is_waiting)
        longest += kPingIdleAfter;
    else if (!connection_.has_unsent())
        longest += std::chrono::duration_cast<Clock::duration>(on_the_way);
    return quiet > longest;
}

}  // namespace divemesh::sensor
