// sensor_window --program build/release/divemesh --dive DIR: a minute at the surface on bad wifi. A
// sensor that kept ten statuses a second for 20 s speaks through a proxy that behaves like bad
// Wi-Fi at 64 kbit/s with 200 ms delay, and the link is cut twice. Prints one JSON: when, after
// each connect, the server had the newest status and an image, how much of the backlog came, and
// what the agent needed of the processor.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <soci/soci.h>
#include <sys/socket.h>
#include <thread>

#include "storage/token_store.hpp"
#include "tests/bench/bench_main.hpp"
#include "tests/bench/process_usage.hpp"
#include "tests/bench/raw_socket.hpp"
#include "tests/bench/served.hpp"
#include "tests/paths.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using nlohmann::json;

constexpr int kBytesPerS = 8000;  // 64 kbit/s
constexpr int kDelay_ms = 200;    // each way

std::int64_t now_ms() {
    return std::chrono::duration_cast<std::chrono::milliseconds>(
               std::chrono::system_clock::now().time_since_epoch())
        .count();
}

struct Setting {
    fs::path program;
    fs::path dive;
    std::string mode = "half-open";
    int seconds = 60;
    int cut_after_s = 20;
};

class Window {
public:
    explicit Window(const Setting& setting) : setting_(setting) {
        fs::create_directories(folder_ / "data");
        fs::create_directories(folder_ / "agent");
        fs::create_directories(folder_ / "proxy");
        storage::Catalog catalog("sqlite://" + (folder_ / "data/catalog.db").string());
        storage::TokenStore tokens(catalog);
        token_ = tokens.create({.name = "bench", .scopes = {"admin"}}).secret;
        sensor_token_ =
            tokens.create({.name = "rig", .scopes = {"sensor:push"}, .sensor = "rig"}).secret;
        server_.emplace(setting.program, folder_ / "data");
        socket_ = connect_to(server_->port(), 0);
    }

    json run() {
        gather_backlog();
        const json before = sensor();
        const int port = free_port();
        Process proxy(proxy_command(port), folder_ / "proxy");
        std::this_thread::sleep_for(500ms);
        Process agent(agent_command("http://127.0.0.1:" + std::to_string(port)), folder_ / "agent");
        const std::int64_t began_ms = now_ms();
        while (now_ms() < began_ms + 1000 * setting_.seconds) look();
        const double cpu_s = cpu_seconds_of(agent.pid());
        const json after = sensor();
        proxy.send(SIGTERM);
        proxy.wait(5s);
        return {{"mode", setting_.mode},
                {"bytes_per_s", kBytesPerS},
                {"delay_ms", kDelay_ms},
                {"seconds", setting_.seconds},
                {"connects", connects(began_ms)},
                {"statuses_seen_live", statuses_ms_.size()},
                {"pictures", images_ms_.size()},
                {"backlog_messages", num_stored() - static_cast<int>(statuses_ms_.size())},
                {"proxy", json::parse(proxy.stdout_text())},
                {"agent_cpu_share", cpu_s / setting_.seconds},
                {"agent_said", agent.stderr_text()}};
    }

private:
    // A link that is not there: what is said stays on the disk.
    void gather_backlog() {
        Process agent(agent_command("http://127.0.0.1:" + std::to_string(free_port()),
                                    {"--status-every", "0.1", "--preview-every", "2"}),
                      folder_ / "agent");
        std::this_thread::sleep_for(20s);
        agent.send(SIGTERM);
        agent.wait(10s);
    }

    std::vector<std::string> proxy_command(int port) const {
        const fs::path script = shared_tool("flaky_proxy.mjs");
        return {"/usr/bin/env",
                "node",
                script.string(),
                "--listen",
                std::to_string(port),
                "--target",
                std::to_string(server_->port()),
                "--mode",
                setting_.mode,
                "--cut-after",
                std::to_string(kBytesPerS * setting_.cut_after_s),
                "--cuts",
                "2",
                "--rate",
                std::to_string(kBytesPerS),
                "--delay",
                std::to_string(kDelay_ms)};
    }
    std::vector<std::string> agent_command(const std::string& server,
                                           std::vector<std::string> more = {}) const {
        std::ofstream(folder_ / "token") << sensor_token_;
        std::vector<std::string> command = {setting_.program.string(),
                                            "sensor",
                                            "--server",
                                            server,
                                            "--token-file",
                                            (folder_ / "token").string(),
                                            "--id",
                                            "rig",
                                            "--replay",
                                            setting_.dive.string(),
                                            "--speed",
                                            "0.2",
                                            "--state",
                                            (folder_ / "state").string()};
        command.insert(command.end(), more.begin(), more.end());
        return command;
    }

    json sensor() {
        send_all(socket_.get(),
                 "GET /api/v1/sensors/rig HTTP/1.1\r\nHost: x\r\nAuthorization: Bearer " + token_ +
                     "\r\n\r\n");
        const std::string head = receive_head(socket_.get());
        const auto place = head.find("Content-Length: ");
        std::string body(place == std::string::npos
                             ? 0
                             : std::stoul(head.substr(place + sizeof("Content-Length: ") - 1)),
                         '\0');
        for (std::size_t got = 0; got < body.size();) {
            const auto n = recv(socket_.get(), body.data() + got, body.size() - got, 0);
            if (n <= 0) throw std::runtime_error("the server went away");
            got += static_cast<std::size_t>(n);
        }
        return json::parse(body);
    }
    void look() {
        const json shown = sensor();
        const std::int64_t now = now_ms();
        if (const auto at = shown.value("status_at_ms", std::int64_t{0}); at > status_at_ms_) {
            status_at_ms_ = at;
            statuses_ms_.push_back(now);
        }
        std::int64_t newest = 0;
        for (const auto& preview : shown.value("previews", json::object()))
            newest = std::max(newest, preview.at("id").get<std::int64_t>());
        if (newest > preview_) {
            preview_ = newest;
            images_ms_.push_back(now);
        }
        std::this_thread::sleep_for(20ms);
    }
    int num_stored() {
        storage::Catalog catalog("sqlite://" + (folder_ / "data/catalog.db").string());
        int num = 0;
        catalog.read([&](soci::session& session) {
            session << "SELECT COUNT(*) FROM sensor_statuses", soci::into(num);
        });
        return num;
    }

    // When streams were opened, by the server's log.
    json connects(std::int64_t began_ms) {
        json all = json::array();
        for (const std::int64_t at : server_->times_of("/api/v1/sensors/rig/stream")) {
            const auto after = [&](const std::vector<std::int64_t>& times) -> json {
                const auto next = std::lower_bound(times.begin(), times.end(), at);
                if (next == times.end()) return nullptr;
                return 0.001 * static_cast<double>(*next - at);
            };
            all.push_back({{"at_s", 0.001 * static_cast<double>(at - began_ms)},
                           {"status_after_s", after(statuses_ms_)},
                           {"picture_after_s", after(images_ms_)}});
        }
        return all;
    }

    Setting setting_;
    TemporaryFolder folder_;
    std::string token_;
    std::string sensor_token_;
    std::optional<Served> server_;
    FileDescriptor socket_;
    std::int64_t status_at_ms_ = 0;
    std::int64_t preview_ = 0;
    std::vector<std::int64_t> statuses_ms_;
    std::vector<std::int64_t> images_ms_;
};

int run(int argc, char** argv) {
    CLI::App app("Measures what a sensor transmits in a minute at the surface over a bad link.");
    Setting setting;
    app.add_option("--program", setting.program, "path of the divemesh program")->required();
    app.add_option("--dive", setting.dive, "dive that the sensor records")->required();
    app.add_option("--mode", setting.mode, "kind of cuts: reset, half-open, stall")
        ->capture_default_str();
    app.add_option("--seconds", setting.seconds, "length of the link, s")->capture_default_str();
    CLI11_PARSE(app, argc, argv);
    prepare_for_many_connections();
    Window window(setting);
    std::cout << window.run().dump(2) << '\n';
    return 0;
}

}  // namespace
}  // namespace divemesh

int main(int argc, char** argv) { return divemesh::run_or_say_why(divemesh::run, argc, argv); }
