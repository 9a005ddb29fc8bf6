// sensor_storm --program build/release/divemesh [--seconds N]: 200 sensors speak at once, a status
// a second and an image every five, over streams; 1,000 clients watch five of them each, 100 of
// which do not read; each image is fetched once. Prints one JSON: how long it takes from what a
// sensor sends to who watches it, how long a sensor waits for its answer, and what the server
// needs.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <charconv>
#include <iostream>
#include <nlohmann/json.hpp>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <thread>

#include "storage/token_store.hpp"
#include "tests/bench/bench_main.hpp"
#include "tests/bench/process_usage.hpp"
#include "tests/bench/raw_socket.hpp"
#include "tests/bench/served.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/stats/quantile.hpp"

namespace divemesh {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using nlohmann::json;

constexpr int kNumSensors = 200;
constexpr int kNumWatchers = 1'000;
constexpr int kNumSilent = 100;
constexpr int kWatched = 5;  // sensors by each
constexpr int kPreviewEvery = 5;
constexpr std::size_t kImageBytes = 24 << 10;

std::int64_t now_us() {
    return std::chrono::duration_cast<std::chrono::microseconds>(Clock::now().time_since_epoch())
        .count();
}

std::string name_of(int sensor) { return "rig-" + std::to_string(sensor % kNumSensors); }

// A client's frame (RFC 6455, 5.2) with a mask of zeros.
std::string frame_of(std::string_view payload, bool is_binary) {
    std::string frame(1, is_binary ? '\x82' : '\x81');
    if (payload.size() < 126) {
        frame += static_cast<char>(0x80U | payload.size());
    } else if (payload.size() < 65536) {
        frame += '\xFE';
        for (const int shift : {8, 0}) frame += static_cast<char>(payload.size() >> shift & 0xFFU);
    } else {
        frame += '\xFF';
        for (int shift = 56; shift >= 0; shift -= 8)
            frame += static_cast<char>(payload.size() >> shift & 0xFFU);
    }
    return frame.append(4, '\0').append(payload);
}

// 8 x 8 pixels of grey, and a comment that makes it as long as an image of a camera.
std::string image() {
    const unsigned char head[] = {0xFF, 0xD8, 0xFF, 0xC0, 0, 11, 8, 0, 8, 0, 8, 1, 1, 0x11, 0};
    std::string bytes(reinterpret_cast<const char*>(head), sizeof head);
    const std::size_t comment = kImageBytes - bytes.size() - 6;
    bytes += "\xFF\xFE";
    bytes += static_cast<char>(comment >> 8);
    bytes += static_cast<char>(comment & 0xFFU);
    bytes.append(comment - 2, 'x');
    return bytes.append("\xFF\xDA\xFF\xD9");
}

// What comes from the server, cut into frames.
class Incoming {
public:
    template <typename OnFrame>
    void take(std::string_view bytes, const OnFrame& on_frame) {
        rest_ += bytes;
        std::size_t place = 0;
        for (std::size_t length = 0; const std::size_t head = head_at(place, length);) {
            on_frame(static_cast<unsigned char>(rest_[place]) & 15U,
                     std::string_view(rest_).substr(place + head, length));
            place += head + length;
        }
        rest_.erase(0, place);
    }

private:
    // Bytes before the payload of the frame at `place`; 0: it is not whole yet.
    std::size_t head_at(std::size_t place, std::size_t& length) const {
        const std::size_t left = rest_.size() - place;
        if (left < 2) return 0;
        const auto byte = [&](std::size_t i) {
            return static_cast<unsigned char>(rest_[place + i]);
        };
        const unsigned code = byte(1) & 127U;
        const std::size_t num = code == 126 ? 2 : code == 127 ? 8 : 0;
        if (left < 2 + num) return 0;
        length = num == 0 ? code : 0;
        for (std::size_t i = 0; i < num; ++i) length = length << 8 | byte(2 + i);
        return left < 2 + num + length ? 0 : 2 + num;
    }

    std::string rest_;
};

struct Client {
    FileDescriptor socket;
    Incoming incoming;
    std::int64_t sent_us = 0;  // by a sensor, unanswered
    int sequence = 0;
};

// -1 without values.
double percentile(const std::vector<double>& values, double share) {
    return values.empty() ? -1.0 : stats::lower_quantile(values, share);
}

json summary(const std::vector<double>& values) {
    return {{"num", values.size()},
            {"median_ms", percentile(values, 0.5)},
            {"p99_ms", percentile(values, 0.99)},
            {"worst_ms", percentile(values, 1.0)}};
}

// The number after `key`; 0: there is none.
std::int64_t number_after(std::string_view text, std::string_view key) {
    const auto found = text.find(key);
    std::int64_t number = 0;
    if (found != std::string_view::npos)
        std::from_chars(text.data() + found + key.size(), text.data() + text.size(), number);
    return number;
}

class Storm {
public:
    Storm(const Served& server, storage::Catalog& catalog, std::string token)
        : server_(server), token_(std::move(token)), epoll_(epoll_create1(EPOLL_CLOEXEC)) {
        clients_.resize(kNumSensors + kNumWatchers);
        for (int i = 0; i < kNumSensors; ++i) {
            const std::string secret =
                storage::TokenStore(catalog)
                    .create({.name = name_of(i), .scopes = {"sensor:push"}, .sensor = name_of(i)})
                    .secret;
            open(i, "/api/v1/sensors/" + name_of(i) + "/stream", secret, 0);
            say_status(i);
        }
        std::this_thread::sleep_for(2s);  // until all are known
        for (int i = 0; i < kNumWatchers; ++i) {
            std::string target = "/api/v1/events?sensors=" + name_of(kWatched * i);
            for (int k = 1; k < kWatched; ++k) target += "," + name_of(kWatched * i + k);
            open(kNumSensors + i, target, token_, i < kNumSilent ? 4096 : 0);
        }
    }

    json run(std::chrono::seconds duration) {
        const auto began = Clock::now();
        const double cpu_before = cpu_seconds_of(server_.pid());
        std::jthread fetching([this](const std::stop_token& stop) { fetch(stop); });
        measures_from_us_ = now_us();
        auto alive_at = began;
        for (std::int64_t turn = 0;; ++turn) {
            const auto at = began + turn * 1000ms / kNumSensors;
            if (at >= began + duration) break;
            hear_until(at);
            const int sensor = static_cast<int>(turn % kNumSensors);
            say_status(sensor);
            const int other = (sensor + kNumSensors / 2) % kNumSensors;  // between two statuses
            if ((turn / kNumSensors + other) % kPreviewEvery == 0) say_preview(other);
            if (Clock::now() >= alive_at) say_alive();
            if (Clock::now() >= alive_at) alive_at += 5s;
        }
        hear_until(Clock::now() + 2s);
        const double seconds = std::chrono::duration<double>(Clock::now() - began).count();
        fetching.request_stop();
        fetching.join();
        return {
            {"seconds", seconds},
            {"sensors", kNumSensors},
            {"watchers", kNumWatchers},
            {"do_not_read", kNumSilent},
            {"push_to_watcher", summary(told_ms_)},
            {"push_to_answer", summary(answered_ms_)},
            {"frames_per_s", static_cast<double>(told_ms_.size()) / seconds},
            {"pictures_fetched", num_fetched_.load()},
            {"server_cpu_share", (cpu_seconds_of(server_.pid()) - cpu_before) / seconds},
            {"peak_memory_mib", static_cast<double>(peak_memory_bytes_of(server_.pid()) >> 20)}};
    }

private:
    void open(int i, const std::string& target, const std::string& token, int receive_buffer) {
        Client& client = clients_[static_cast<std::size_t>(i)];
        client.socket = connect_to(server_.port(), receive_buffer);
        open_web_socket(client.socket.get(), target, token);
        const bool reads = i < kNumSensors || i >= kNumSensors + kNumSilent;
        epoll_event event{.events = EPOLLIN, .data = {.u32 = static_cast<unsigned>(i)}};
        if (reads) epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, client.socket.get(), &event);
    }

    void say(Client& client, const json& message, const std::string* jpeg) {
        client.sent_us = now_us();
        if (jpeg == nullptr) {
            const json report = {{"boot_id", "boot"}, {"messages", {message}}};
            return send_all(client.socket.get(), frame_of(report.dump(), false));
        }
        json header = message;
        header["boot_id"] = "boot";
        const std::string text = header.dump();
        std::string payload;
        for (int shift = 24; shift >= 0; shift -= 8)
            payload += static_cast<char>(text.size() >> shift & 0xFFU);
        send_all(client.socket.get(), frame_of(payload + text + *jpeg, true));
    }
    void say_status(int sensor) {
        Client& client = clients_[static_cast<std::size_t>(sensor)];
        say(client,
            {{"seq", client.sequence},
             {"uptime_ms", now_us() / 1000},
             {"status",
              {{"recording", true},
               {"battery", 0.7},
               {"depth_m", 0.01 * (client.sequence % 100)},
               {"num_frames", 20 * client.sequence},
               {"temperature_c", 9.0},
               {"orientation", {1.0, 0.0, 0.0, 0.0}},
               {"sent_us", now_us()}}}},
            nullptr);
        ++client.sequence;
    }
    void say_preview(int sensor) {
        Client& client = clients_[static_cast<std::size_t>(sensor)];
        say(client,
            {{"seq", client.sequence},
             {"uptime_ms", now_us() / 1000},
             {"preview", {{"camera", "cam0"}, {"sent_us", now_us()}}}},
            &image_);
        ++client.sequence;
    }
    // As the answers to pings would: an empty pong.
    void say_alive() {
        for (std::size_t i = 0; i < clients_.size(); ++i) {
            const bool reads = i < kNumSensors || i >= kNumSensors + kNumSilent;
            if (reads)
                send(clients_[i].socket.get(), "\x8a\x80\0\0\0\0", 6, MSG_NOSIGNAL | MSG_DONTWAIT);
        }
    }

    void hear_until(Clock::time_point end) {
        std::array<epoll_event, 256> events;
        do {
            const auto left =
                std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
            const int num = epoll_wait(epoll_.get(),
                                       events.data(),
                                       static_cast<int>(events.size()),
                                       static_cast<int>(std::max<std::int64_t>(0, left.count())));
            for (int i = 0; i < num; ++i) hear(events[static_cast<std::size_t>(i)].data.u32);
        } while (Clock::now() < end);
    }
    void hear(std::size_t i) {
        Client& client = clients_[i];
        const auto n = recv(client.socket.get(), buffer_.data(), buffer_.size(), MSG_DONTWAIT);
        if (n == 0) throw std::runtime_error("the server closed client " + std::to_string(i));
        if (n < 0) return;
        client.incoming.take({buffer_.data(), static_cast<std::size_t>(n)},
                             [&](unsigned code, std::string_view text) {
                                 if (code == 8)
                                     throw std::runtime_error("goodbye: " + std::string(text));
                                 if (code != 1) return;
                                 if (i < kNumSensors)
                                     hear_answer(client, text);
                                 else
                                     hear_frame(text);
                             });
    }
    void hear_answer(Client& client, std::string_view text) {
        if (text.find("\"refused\"") != std::string_view::npos)
            throw std::runtime_error(std::string(text));
        if (text.find("\"answer\"") != std::string_view::npos && client.sent_us > measures_from_us_)
            answered_ms_.push_back(0.001 * static_cast<double>(now_us() - client.sent_us));
    }
    void hear_frame(std::string_view text) {
        if (text.find("sensor.delta") == std::string_view::npos) return;
        const std::int64_t sent_us = number_after(text, "\"sent_us\":");
        if (sent_us > measures_from_us_)
            told_ms_.push_back(0.001 * static_cast<double>(now_us() - sent_us));
    }

    // Fetches each image once, as a viewer does.
    void fetch(const std::stop_token& stop) {
        const FileDescriptor socket = connect_to(server_.port(), 0);
        std::vector<char> buffer(std::size_t{64} << 10);
        for (int sensor = 0; !stop.stop_requested(); sensor = (sensor + 1) % kNumSensors) {
            send_all(socket.get(),
                     "GET /api/v1/sensors/" + name_of(sensor) +
                         "/preview.jpg HTTP/1.1\r\nHost: x\r\nAuthorization: Bearer " + token_ +
                         "\r\n\r\n");
            const std::string head = receive_head(socket.get());
            auto left = static_cast<std::size_t>(number_after(head, "Content-Length: "));
            while (left > 0) {
                const auto n = recv(socket.get(), buffer.data(), std::min(left, buffer.size()), 0);
                if (n <= 0) throw std::runtime_error("no image");
                left -= static_cast<std::size_t>(n);
            }
            if (head.starts_with("HTTP/1.1 200")) ++num_fetched_;
            std::this_thread::sleep_for(1000ms / (kNumSensors / kPreviewEvery));
        }
    }

    const Served& server_;
    std::string token_;
    FileDescriptor epoll_;
    std::vector<Client> clients_;
    std::vector<char> buffer_ = std::vector<char>(std::size_t{256} << 10);
    const std::string image_ = image();
    std::int64_t measures_from_us_ = std::numeric_limits<std::int64_t>::max();
    std::vector<double> told_ms_;
    std::vector<double> answered_ms_;
    std::atomic<int> num_fetched_ = 0;
};

int run(int argc, char** argv) {
    CLI::App app("Measures the load of sensors and of clients that watch them on one server.");
    fs::path program;
    int seconds = 30;
    app.add_option("--program", program, "path of the divemesh program")->required();
    app.add_option("--seconds", seconds, "length of the storm, s")->capture_default_str();
    CLI11_PARSE(app, argc, argv);
    prepare_for_many_connections();

    const TemporaryFolder folder;
    fs::create_directories(folder / "data");
    storage::Catalog catalog("sqlite://" + (folder / "data/catalog.db").string());
    const std::string token =
        storage::TokenStore(catalog).create({.name = "bench", .scopes = {"admin"}}).secret;
    const Served server(program, folder / "data");
    Storm storm(server, catalog, token);
    std::cout << storm.run(std::chrono::seconds(seconds)).dump(2) << '\n';
    return 0;
}

}  // namespace
}  // namespace divemesh

int main(int argc, char** argv) { return divemesh::run_or_say_why(divemesh::run, argc, argv); }
