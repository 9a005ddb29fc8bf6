#include "server/sensor_socket.hpp"

#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <deque>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "api/error_response.hpp"
#include "api/in_pool.hpp"
#include "api/metrics.hpp"
#include "api/parse_json.hpp"
#include "api/sensors/report_queue.hpp"
#include "api/sensors/sensor_hub.hpp"
#include "api/token_watch.hpp"
#include "schemas/log.hpp"
#include "schemas/sensor_message.hpp"
#include "schemas/wall_clock.hpp"
#include "server/web_socket.hpp"
#include "storage/command_store.hpp"

namespace divemesh::server {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = boost::beast::websocket;
using nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kMaxFrameBytes = std::size_t{1} << 20;
constexpr std::size_t kMaxWaiting = 64;  // frames
constexpr std::size_t kMaxWaitingBytes = std::size_t{1} << 20;

// A frame as it was read: a report, or the answer to an invalid one.
struct Incoming {
    SensorReport report;
    std::string refusal;  // "": valid report
    std::size_t num_bytes = 0;
};

// The reports that one transaction writes.
struct Batch {
    SensorReport report;
    std::vector<std::string> refusals;

    bool is_empty() const { return report.messages.empty() && report.lost.empty(); }
};

class SensorSocket : public ClientSocket {
public:
    explicit SensorSocket(std::shared_ptr<Connection> below)
        : ClientSocket(std::move(below)),
          pause(socket.get_executor()),
          room_(socket.get_executor()) {
        pause.expires_at(Clock::time_point::max());  // only ever cancelled
        room_.expires_at(Clock::time_point::max());
    }

    void look_for_commands() {
        has_commands = true;
        pause.cancel();
    }

    void put(Incoming incoming) {
        num_bytes_ += incoming.num_bytes;
        waiting_.push_back(std::move(incoming));
        pause.cancel();
    }
    asio::awaitable<void> wait_for_room() {
        while (!closing && (waiting_.size() >= kMaxWaiting || num_bytes_ >= kMaxWaitingBytes))
            co_await room_.async_wait(kAwaitErrors);
    }
    bool has_frames() const { return !waiting_.empty(); }
    Batch take() {
        Batch batch;
        while (!waiting_.empty() && fits(batch, waiting_.front())) {
            Incoming next = std::move(waiting_.front());
            waiting_.pop_front();
            num_bytes_ -= next.num_bytes;
            add(batch, std::move(next));
        }
        room_.cancel();
        return batch;
    }

    asio::steady_timer pause;
    bool has_commands = true;  // there may be commands to send

private:
    void wake() override {
        pause.cancel();
        room_.cancel();
    }
    static bool fits(const Batch& batch, const Incoming& next) {
        if (!next.refusal.empty() || batch.is_empty()) return true;
        return next.report.boot_id == batch.report.boot_id &&
               batch.report.messages.size() + next.report.messages.size() <= kMaxMessages &&
               batch.report.lost.size() + next.report.lost.size() <= kMaxLost;
    }
    static void add(Batch& batch, Incoming next) {
        if (!next.refusal.empty()) return batch.refusals.push_back(std::move(next.refusal));
        batch.report.boot_id = next.report.boot_id;
        std::move(next.report.messages.begin(),
                  next.report.messages.end(),
                  std::back_inserter(batch.report.messages));
        batch.report.lost.insert(
            batch.report.lost.end(), next.report.lost.begin(), next.report.lost.end());
    }

    asio::steady_timer room_;
    std::deque<Incoming> waiting_;
    std::size_t num_bytes_ = 0;
};

CloseReason replaced() {
    return {kReplaced, "another stream of this sensor began: give each device its own id"};
}

// The stream's connection to the sensor hub, until it is destroyed.
class HubConnection {
public:
    HubConnection(api::SensorHub& sensor_hub,
                  std::string name,
                  const std::shared_ptr<SensorSocket>& sensor)
        : sensor_hub_(sensor_hub), sensor_(std::move(name)) {
        const auto executor = sensor->socket.get_executor();
        const auto wake = [sensor] { sensor->look_for_commands(); };
        const auto end = [sensor] { sensor->close(replaced()); };
        connection_ = sensor_hub_.connect(sensor_,
                                          {[executor, wake] { asio::post(executor, wake); },
                                           [executor, end] { asio::post(executor, end); }});
    }
    ~HubConnection() { sensor_hub_.disconnect(sensor_, connection_); }
    HubConnection(const HubConnection&) = delete;
    HubConnection& operator=(const HubConnection&) = delete;

private:
    api::SensorHub& sensor_hub_;
    std::string sensor_;
    std::uint64_t connection_;
};

// Returns the sequence numbers that could be read of a refused frame.
json sequences_in(const json& frame) {
    json sequences = json::array();
    const auto add = [&](const json& message) {
        if (!message.is_object()) return;
        const auto sequence = message.find("seq");
        if (sequence != message.end() && sequence->is_number_integer())
            sequences.push_back(*sequence);
    };
    add(frame);
    if (frame.is_object() && frame.contains("messages") && frame["messages"].is_array())
        for (const json& message : frame["messages"]) add(message);
    return sequences;
}

Incoming read_frame(const api::Request& request, std::string_view frame, bool is_binary) {
    Incoming incoming;
    incoming.num_bytes = frame.size();
    json header;
    try {
        if (is_binary) {
            const PreviewFrame parts = split_preview(frame);
            header = api::parse_json(parts.header);
            incoming.report = sensor_preview(header, parts.jpeg);
        } else {
            header = api::parse_json(frame);
            incoming.report = sensor_report(header);
        }
    } catch (const std::exception&) {
        const api::Response problem = api::error_response(request, std::current_exception());
        json refusal = {{"refused", json::parse(std::get<std::string>(problem.body))},
                        {"messages", sequences_in(header)}};
        if (header.is_object() && header.contains("boot_id"))
            refusal["boot_id"] = header["boot_id"];
        incoming.refusal = api::json_text(refusal);
    }
    return incoming;
}

asio::awaitable<void> read_frames(std::shared_ptr<SensorSocket> sensor, api::Request request) {
    const std::shared_ptr<ClientSocket> client = sensor;
    while (!sensor->closing) {
        auto message = co_await read_message(client, kMaxFrameBytes);
        if (!message) break;
        const auto bytes = message->cdata();
        const std::string_view frame(static_cast<const char*>(bytes.data()), bytes.size());
        sensor->put(read_frame(request, frame, sensor->socket.got_binary()));
        message.reset();  // frees an image's memory before the next read
        co_await sensor->wait_for_room();
    }
}

// Returns false if the sensor is gone, or the socket closes.
asio::awaitable<bool> write(std::shared_ptr<SensorSocket> sensor, std::string frame) {
    const auto [error, n] = co_await sensor->socket.async_write(asio::buffer(frame), kAwaitErrors);
    co_return !error && !sensor->closing;
}

json ranges_of(const SensorReport& report) {
    std::vector<std::int64_t> sequences;
    for (const SensorMessage& message : report.messages) sequences.push_back(message.sequence);
    std::sort(sequences.begin(), sequences.end());
    json pairs = json::array();
    for (const std::int64_t sequence : sequences) {
        if (!pairs.empty() && sequence <= pairs.back()[1].get<std::int64_t>() + 1)
            pairs.back()[1] = sequence;
        else
            pairs.push_back({sequence, sequence});
    }
    return pairs;
}

std::string answer_text(const SensorAnswer& answer, const json& committed) {
    return api::json_text({{"answer", answer}, {"committed", committed}});
}

class Answering {
public:
    Answering(std::shared_ptr<SensorSocket> sensor,
              api::SensorStream stream,
              const SessionContext& context)
        : sensor_(std::move(sensor)), stream_(std::move(stream)), services_(context.services) {}

    // Runs until the sensor disconnects or the connection is stopped.
    asio::awaitable<void> run() {
        bool goes_on = co_await write(sensor_, welcome());
        while (goes_on) {
            const bool has_work = sensor_->has_frames() || (is_heard_ && sensor_->has_commands);
            if (has_work)
                goes_on = co_await round();
            else
                co_await sensor_->pause.async_wait(kAwaitErrors);
            goes_on = goes_on && !sensor_->closing;
        }
    }

private:
    static std::string welcome() {
        return api::json_text({{"welcome", {{"time_ms", wall_time_ms()}}}});
    }

    asio::awaitable<bool> round() {
        bool goes_on = co_await check_token();
        if (goes_on && sensor_->has_frames()) {
            Batch batch = sensor_->take();
            goes_on = co_await answer(std::move(batch));
        }
        if (goes_on && is_heard_ && sensor_->has_commands) goes_on = co_await hand_over();
        co_return goes_on;
    }

    asio::awaitable<bool> check_token() {
        const bool is_valid = co_await token_.is_valid_now(services_);
        if (!is_valid) sensor_->close(token_has_ended());
        co_return is_valid;
    }

    asio::awaitable<bool> answer(Batch batch) {
        bool goes_on = true;
        for (std::size_t i = 0; goes_on && i < batch.refusals.size(); ++i) {
            ++services_.metrics.refused_frames;
            goes_on = co_await write(sensor_, std::move(batch.refusals[i]));
        }
        if (!goes_on || batch.is_empty()) co_return goes_on;
        const json committed = ranges_of(batch.report);
        for (const SensorMessage& message : batch.report.messages)
            is_heard_ = is_heard_ || !message.historical;
        storage::IncomingReport incoming{stream_.sensor, stream_.project, std::move(batch.report)};
        const SensorAnswer answer = co_await services_.reports.submit(std::move(incoming));
        services_.metrics.sensor_messages += answer.num_new;
        co_return co_await write(sensor_, answer_text(answer, committed));
    }

    // Sends commands. Those sent on an earlier stream may have been lost with it, so they are sent
    // again.
    asio::awaitable<bool> hand_over() {
        sensor_->has_commands = false;
        auto take = [&catalog = services_.catalog,
                     sensor = stream_.sensor,
                     again = std::exchange(is_anew_, false)] {
            return storage::CommandStore(catalog).take(sensor, again);
        };
        const auto commands = co_await api::in_pool(services_.pool, std::move(take));
        bool goes_on = true;
        for (std::size_t i = 0; goes_on && i < commands.size(); ++i) {
            const SensorCommand& command = commands[i];
            std::string frame =
                api::json_text({{"command",
                                 {{"id", command.id},
                                  {"name", command.name},
                                  {"arguments", arguments_at(command, wall_time_ms())},
                                  {"expires_at_ms", command.expires_at_ms}}}});
            goes_on = co_await write(sensor_, std::move(frame));
        }
        co_return goes_on;
    }

    std::shared_ptr<SensorSocket> sensor_;
    api::SensorStream stream_;
    api::Services services_;
    api::TokenWatch token_{stream_.token_id};
    bool is_heard_ = false;  // it has sent a current report
    bool is_anew_ = true;
};

// Returns the close code. The sensor keeps what cannot be written now and sends it again; what
// belongs to another project will never be accepted.
CloseReason reason_of(const std::exception& failure) {
    const auto* error = dynamic_cast<const Error*>(&failure);
    const bool is_final = error != nullptr && error->code() == ErrorCode::Conflict;
    constexpr std::size_t kMaxReasonBytes = 120;  // RFC 6455, 5.5
    const std::string why = error != nullptr ? error->what() : "the catalog cannot be written now";
    return {is_final ? websocket::close_code::policy_error : websocket::close_code::try_again_later,
            why.substr(0, kMaxReasonBytes)};
}

}  // namespace

asio::awaitable<void> hear_sensor(std::shared_ptr<Connection> connection,
                                  std::shared_ptr<RequestBody> request_body,
                                  api::Request request,
                                  api::SensorStream stream,
                                  SessionContext context) {
    connection->stream.expires_never();  // from here on the WebSocket has timeouts of its own
    auto sensor = std::make_shared<SensorSocket>(connection);
    sensor->set_timeouts(context.timeouts);
    connection->on_stop = [sensor] { sensor->close(server_stops()); };
    connection->on_abort = [sensor] { beast::get_lowest_layer(sensor->socket).close(); };
    const auto [refused] =
        co_await sensor->socket.async_accept(request_body->message(), kAwaitErrors);
    if (!refused) {
        const HubConnection hub_connection(context.services.sensor_hub, stream.sensor, sensor);
        ++context.services.metrics.sensor_streams;
        const auto executor = sensor->socket.get_executor();
        asio::co_spawn(executor, read_frames(sensor, request), asio::detached);
        asio::co_spawn(
            executor, watch_silence(sensor, context.timeouts.web_socket), asio::detached);
        try {
            Answering answering(sensor, stream, context);
            co_await answering.run();
        } catch (const std::exception& error) {
            log_warning(
                {{"event", "sensor_not_heard"}, {"sensor", stream.sensor}, {"what", error.what()}});
            sensor->close(reason_of(error));
        }
        sensor->close(server_stops());  // if there is no other reason yet
        co_await sensor->socket.async_close(sensor->reason, kAwaitErrors);
        --context.services.metrics.sensor_streams;
    }
    beast::get_lowest_layer(sensor->socket).close();
    connection->on_stop = nullptr;
    connection->on_abort = nullptr;
}

}  // namespace divemesh::server
