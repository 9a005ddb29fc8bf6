// service_bench --program build/release/divemesh [--seconds N]: how quickly one server answers GET
// of one job out of 10,000, and how much memory it takes when 1,000 clients watch events, 100 of
// which do not read, while 100 others upload. Prints one JSON. Needs wrk.
#include <CLI/CLI.hpp>
#include <atomic>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <poll.h>
#include <sys/socket.h>
#include <thread>

#include "schemas/content_hash.hpp"
#include "storage/event_store.hpp"
#include "storage/job_store.hpp"
#include "storage/token_store.hpp"
#include "tests/bench/bench_main.hpp"
#include "tests/bench/process_usage.hpp"
#include "tests/bench/raw_socket.hpp"
#include "tests/bench/served.hpp"
#include "tests/paths.hpp"
#include "tests/ready_dive.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr int kNumJobs = 10'000;
constexpr int kNumReaders = 1'000;
constexpr int kNumSilent = 100;
constexpr auto kSayAliveEvery = 5s;
constexpr int kNumEvents = 2'000;
constexpr int kNumUploads = 100;
constexpr std::size_t kUploadBytes = std::size_t{8} << 20;

double seconds_since(Clock::time_point began) {
    return std::chrono::duration<double>(Clock::now() - began).count();
}

void make_jobs(storage::Catalog& catalog, const fs::path& list) {
    storage::JobStore jobs(catalog);
    storage::NewJob job;
    job.dive_id = make_ready_dive(catalog, "default", sha256_hex("1"));
    std::ofstream lines(list);
    for (int i = 0; i < kNumJobs; ++i) {
        job.preset = i % 2 == 0 ? "standard" : "fast";
        job.options = {{"voxel_m", 0.01 + 1e-6 * i}};
        lines << "/api/v1/jobs/" << jobs.enqueue(job).job.id << '\n';
    }
}

nlohmann::json get_jobs(const Served& server,
                        const fs::path& list,
                        const std::string& token,
                        int seconds) {
    setenv("JOBS", list.c_str(), 1);
    setenv("DIVEMESH_TOKEN", token.c_str(), 1);
    const std::string command = "wrk -t1 -c50 -d" + std::to_string(seconds) + "s -s '" +
                                (source_directory() / "tests/bench/get_job.lua").string() + "' " +
                                server.address();
    FILE* pipe = popen(command.c_str(), "r");
    std::string last;
    for (char line[4096]; pipe != nullptr && std::fgets(line, sizeof line, pipe) != nullptr;)
        if (line[0] == '{') last = line;
    if (pipe == nullptr || pclose(pipe) != 0 || last.empty())
        throw std::runtime_error("wrk failed (apt-get install wrk)");
    return nlohmann::json::parse(last);
}

// Clients of the event stream; those that read look for the text of the last event.
class Readers {
public:
    Readers(int port, const std::string& token) {
        for (int i = 0; i < kNumReaders; ++i) {
            FileDescriptor socket = connect_to(port, i < kNumSilent ? 4096 : 0);
            open_web_socket(socket.get(), "/api/v1/events", token);
            sockets_.push_back({socket.get(), POLLIN, 0});
            open_.push_back(std::move(socket));
        }
    }

    // Until all that read have seen `mark`; how many did.
    int read_until(const std::string& mark, std::chrono::seconds timeout) {
        const auto end = Clock::now() + timeout;
        auto alive_until = Clock::now();
        std::vector<std::string> tails(sockets_.size());
        std::vector<char> buffer(std::size_t{256} << 10);
        int num_done = 0;
        while (num_done < kNumReaders - kNumSilent && Clock::now() < end) {
            if (Clock::now() >= alive_until) {
                say_alive();
                alive_until = Clock::now() + kSayAliveEvery;
            }
            poll(sockets_.data() + kNumSilent, kNumReaders - kNumSilent, 100);
            for (std::size_t i = kNumSilent; i < sockets_.size(); ++i) {
                if ((sockets_[i].revents & POLLIN) == 0) continue;
                const auto n = recv(sockets_[i].fd, buffer.data(), buffer.size(), MSG_DONTWAIT);
                if (n <= 0) sockets_[i].events = 0;
                if (n <= 0) continue;
                std::string text =
                    tails[i] + std::string(buffer.data(), static_cast<std::size_t>(n));
                if (text.find(mark) != std::string::npos) {
                    ++num_done;
                    sockets_[i].events = 0;
                }
                tails[i] = text.substr(text.size() - std::min(text.size(), mark.size()));
            }
        }
        return num_done;
    }

private:
    // As the answers to pings would: an empty pong, masked (RFC 6455, section 5.5.3).
    void say_alive() {
        for (std::size_t i = kNumSilent; i < sockets_.size(); ++i)
            send(sockets_[i].fd, "\x8a\x80\0\0\0\0", 6, MSG_NOSIGNAL | MSG_DONTWAIT);
    }

    std::vector<FileDescriptor> open_;
    std::vector<pollfd> sockets_;  // of `open_`
};

void upload(int port, const std::string& token, std::size_t num_bytes, std::atomic<int>& num_done) {
    const std::string common =
        " HTTP/1.1\r\nHost: x\r\nTus-Resumable: 1.0.0\r\nAuthorization: Bearer " + token + "\r\n";
    const FileDescriptor socket = connect_to(port, 0);
    send_all(socket.get(),
             "POST /api/v1/uploads" + common +
                 "Content-Length: 0\r\nUpload-Length: " + std::to_string(num_bytes) + "\r\n\r\n");
    const std::string made = receive_head(socket.get());
    const auto location = made.find("Location: ");
    if (location != std::string::npos) {
        const std::string path =
            made.substr(location + 10, made.find("\r\n", location) - location - 10);
        send_all(socket.get(),
                 "PATCH " + path + common +
                     "Content-Type: application/offset+octet-stream\r\nUpload-Offset: 0\r\n"
                     "Content-Length: " +
                     std::to_string(num_bytes) + "\r\n\r\n");
        const std::string piece(std::size_t{1} << 20, 'x');
        for (std::size_t sent = 0; sent < num_bytes; sent += piece.size())
            send_all(socket.get(), piece.substr(0, num_bytes - sent));
        if (receive_head(socket.get()).starts_with("HTTP/1.1 204")) ++num_done;
    }
}

void make_events(storage::Catalog& catalog) {
    for (int i = 0; i < kNumEvents; i += 20)
        catalog.transaction([&](soci::session& session) {
            for (int n = i; n < i + 20; ++n)
                storage::EventStore::append(session,
                                            {.project = "default",
                                             .topic = "job",
                                             .subject = "event-" + std::to_string(n + 1) + "-",
                                             .type = "job.state",
                                             .data = {{"text", std::string(800, 'x')}}});
        });
}

nlohmann::json watch_and_upload(const Served& server,
                                storage::Catalog& catalog,
                                const std::string& token,
                                std::size_t large_bytes) {
    Readers readers(server.port(), token);
    const auto connected_bytes = peak_memory_bytes_of(server.pid());
    std::atomic<int> num_uploads = 0;
    std::atomic<int> num_large = 0;
    std::vector<std::jthread> threads;
    if (large_bytes > 0)
        threads.emplace_back([&] { upload(server.port(), token, large_bytes, num_large); });
    for (int i = 0; i < kNumUploads; ++i)
        threads.emplace_back([&] { upload(server.port(), token, kUploadBytes, num_uploads); });
    const auto began = Clock::now();
    threads.emplace_back([&] { make_events(catalog); });
    const int told =
        readers.read_until("event-" + std::to_string(kNumEvents) + "-", std::chrono::seconds(300));
    const double seconds = seconds_since(began);
    threads.clear();
    return {{"readers", kNumReaders},
            {"do_not_read", kNumSilent},
            {"told_all", told},
            {"events", kNumEvents},
            {"seconds", seconds},
            {"uploads", num_uploads.load()},
            {"upload_bytes", kUploadBytes},
            {"large_upload_bytes", num_large * large_bytes},
            {"connected_memory_mib", static_cast<double>(connected_bytes >> 20)},
            {"peak_memory_mib", static_cast<double>(peak_memory_bytes_of(server.pid()) >> 20)}};
}

int run(int argc, char** argv) {
    CLI::App app("Measures the load that one server serves.");
    fs::path program;
    int seconds = 10;
    std::size_t large_bytes = 0;
    app.add_option("--program", program, "path of the divemesh program")->required();
    app.add_option("--seconds", seconds, "length of the GET requests, s")->capture_default_str();
    app.add_option("--large", large_bytes, "bytes of one more upload beside the others");
    CLI11_PARSE(app, argc, argv);
    prepare_for_many_connections();

    const TemporaryFolder folder;
    fs::create_directories(folder / "data");
    storage::Catalog catalog("sqlite://" + (folder / "data/catalog.db").string());
    const std::string token =
        storage::TokenStore(catalog).create({.name = "bench", .scopes = {"admin"}}).secret;
    const Served server(program, folder / "data");
    make_jobs(catalog, folder / "jobs");
    nlohmann::json result;
    result["get_job"] = get_jobs(server, folder / "jobs", token, seconds);
    result["watch_and_upload"] = watch_and_upload(server, catalog, token, large_bytes);
    std::cout << result.dump(2) << '\n';
    return 0;
}

}  // namespace
}  // namespace divemesh

int main(int argc, char** argv) { return divemesh::run_or_say_why(divemesh::run, argc, argv); }
