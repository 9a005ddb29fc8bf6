#include "sensor/link/link.hpp"

#include <condition_variable>
#include <utility>

#include "sensor/clock/uptime.hpp"
#include "sensor/link/connection.hpp"
#include "sensor/link/stream_session.hpp"

namespace divemesh::sensor {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kTick{20};
constexpr milliseconds kGoodbye{500};
constexpr milliseconds kBusyPause{5'000};  // the server is there, but busy
constexpr int kSuperseded = 4409;
constexpr int kPolicy = 1008;
constexpr int kTryLater = 1013;

void sleep_for(milliseconds pause, const std::stop_token& stop) {
    std::mutex mutex;
    std::unique_lock lock(mutex);
    std::condition_variable_any never;
    never.wait_for(lock, stop, pause, [] { return false; });
}

std::string closed_text(const Connection& connection) {
    if (connection.close_code() == kSuperseded)
        return "another device uses the id of this sensor: give each its own id, or stop the other "
               "one";
    if (connection.close_code() == kPolicy)
        return "the server ended the stream, perhaps because the token is no longer valid: " +
               connection.why();
    return "the connection ended: " + connection.why();
}

}  // namespace

Link::Link(api::client::Account account,
           std::string sensor_id,
           MessageRing& ring,
           LinkSettings settings)
    : account_(std::move(account)),
      sensor_id_(std::move(sensor_id)),
      ring_(ring),
      settings_(std::move(settings)),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

Link::~Link() {
    thread_.request_stop();
    thread_.join();
}

LinkState Link::state() const {
    const std::lock_guard lock(mutex_);
    return state_;
}

std::vector<Command> Link::take_commands() {
    const std::lock_guard lock(mutex_);
    return std::exchange(commands_, {});
}

void Link::tell(bool is_connected, const std::string& trouble) {
    const std::lock_guard lock(mutex_);
    const bool has_changed = state_.is_connected != is_connected || state_.trouble != trouble;
    state_.is_connected = is_connected;
    state_.trouble = trouble;
    if (has_changed && settings_.on_event) settings_.on_event(is_connected ? "connected" : trouble);
}

void Link::run(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
        const milliseconds pause = try_once(stop);
        if (!stop.stop_requested()) sleep_for(pause, stop);
    }
}

milliseconds Link::try_once(const std::stop_token& stop) {
    try {
        return serve(stop);
    } catch (const Error& error) {
        tell(false, error.what());
        if (error.code() == ErrorCode::TooMany) return kBusyPause;
        return error.code() == ErrorCode::Unavailable ? settings_.pause : settings_.refused_pause;
    } catch (const std::exception& error) {
        tell(false, std::string("internal error: ") + error.what());
        return kBusyPause;
    }
}

// Serves until the connection ends; returns how long to wait before the next one.
milliseconds Link::serve(const std::stop_token& stop) {
    const std::int64_t asked_at = uptime_ms();
    Connection connection(account_, sensor_id_, settings_.connect_timeout);
    tell(true, "");
    StreamSession session(connection, ring_, order_, rate_, asked_at);
    while (connection.is_open() && !stop.stop_requested()) {
        connection.run(kTick);
        const auto now = Connection::Clock::now();
        session.receive(now, [this](const Command& command) {
            const std::lock_guard lock(mutex_);
            commands_.push_back(command);
        });
        session.send(now, settings_.max_bytes_per_s);
        {
            const std::lock_guard lock(mutex_);
            state_.bytes_per_s = rate_.bytes_per_s(now);
            state_.server_time = session.server_time();
        }
        if (session.is_dead(now, settings_.timeout)) {
            tell(false, "the server no longer answers");
            return settings_.pause;
        }
    }
    if (stop.stop_requested()) {
        connection.close(kGoodbye);
        return settings_.pause;
    }
    tell(false, closed_text(connection));
    const int code = connection.close_code();
    if (code == kSuperseded || code == kPolicy) return settings_.refused_pause;
    return code == kTryLater ? kBusyPause : settings_.pause;
}

}  // namespace divemesh::sensor
