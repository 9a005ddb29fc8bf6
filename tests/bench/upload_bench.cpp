// divemesh_upload_bench --program FILE [--repeat N] [--large]: how fast, how sparing and how
// steadily uploads arrive, as one JSON. Exit 3 when --require is given and a goal is not met.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <numeric>
#include <thread>
#include <unistd.h>

#include "api/client/tus_upload.hpp"
#include "schemas/error.hpp"
#include "tests/bench/counting_sink.hpp"
#include "tests/bench/machine.hpp"
#include "tests/bench/tus_reference.hpp"
#include "tests/end_to_end/process.hpp"
#include "tests/flaky_proxy.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::bench {
namespace {

namespace client = api::client;
namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using json = nlohmann::json;
using namespace std::chrono_literals;

constexpr std::int64_t kMebibyte = 1 << 20;

struct Options {
    fs::path program;
    fs::path folder;  // of the server's data; "": a temporary one
    int num_repeats = 5;
    bool large = false;
    bool require = false;
};

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

// The same noise again and again, of any length.
class Noise : public client::ByteSource {
public:
    explicit Noise(std::int64_t size_bytes) : size_bytes_(size_bytes), block_(kMebibyte + 4099) {
        std::uint64_t state = 1;
        for (char& c : block_)
            c = static_cast<char>((state = state * 6364136223846793005U + 1442695040888963407U) >>
                                  56);
    }
    std::int64_t size_bytes() const override { return size_bytes_; }
    std::size_t read_at(std::int64_t offset, std::span<char> buffer) override {
        const auto at = static_cast<std::size_t>(offset) % block_.size();
        const auto n = std::min(
            {buffer.size(), block_.size() - at, static_cast<std::size_t>(size_bytes_ - offset)});
        std::copy_n(block_.begin() + static_cast<std::ptrdiff_t>(at), n, buffer.begin());
        return n;
    }

private:
    std::int64_t size_bytes_;
    std::vector<char> block_;
};

// `divemesh serve` without workers, over a data folder.
class ServerUnderTest {
public:
    ServerUnderTest(const Options& options, const fs::path& folder)
        : process_({options.program.string(),
                    "serve",
                    "--data",
                    (folder / "data").string(),
                    "--listen",
                    "127.0.0.1:0",
                    "--workers",
                    "0"},
                   folder) {
        const std::string mark = "listening on http://127.0.0.1:";
        const bool ready =
            wait_until(60s, [&] { return process_.stdout_text().find(mark) != std::string::npos; });
        if (!ready) throw std::runtime_error("no server: " + process_.stderr_text());
        const std::string text = process_.stdout_text();
        port_ = std::stoi(text.substr(text.find(mark) + mark.size()));
        std::ifstream(folder / "data/admin.token") >> token_;
    }

    int port() const { return port_; }
    const std::string& token() const { return token_; }
    client::Account account(int port) const {
        return {client::parse_server_url("http://127.0.0.1:" + std::to_string(port)), token_};
    }

    double peak_memory_mib() const {
        std::ifstream status("/proc/" + std::to_string(process_.pid()) + "/status");
        for (std::string line; std::getline(status, line);)
            if (line.starts_with("VmHWM:")) return std::stod(line.substr(6)) / 1024.0;
        return 0.0;
    }

private:
    Process process_;
    std::string token_;
    int port_ = 0;
};

client::HttpResponse tus(client::HttpConnection& connection,
                         const client::Account& account,
                         const std::string& method,
                         const std::string& target,
                         client::QueryParameters headers,
                         const client::BodyRange* body = nullptr) {
    client::HttpRequest request{method, target, client::authorization(account), ""};
    request.headers.emplace_back("Tus-Resumable", "1.0.0");
    for (auto& header : headers) request.headers.push_back(std::move(header));
    auto response = body ? connection.send(request, *body) : connection.send(request);
    if (response.status >= 300) throw client::error_of(response);
    return response;
}

enum class Durable { Answered, Synced };

// One PATCH of everything; the seconds from its first byte until it is durable: answered, or for a
// server that does not promise so much, answered and the machine's disks in step.
double seconds_of_patch(const client::Account& account,
                        client::ByteSource& source,
                        Durable durable = Durable::Answered) {
    client::HttpConnection connection(account.server, 600s);
    const auto size = std::to_string(source.size_bytes());
    const auto path = tus(connection, account, "POST", "/api/v1/uploads", {{"Upload-Length", size}})
                          .header("location");
    client::BodyRange body;
    body.source = &source;
    body.length = source.size_bytes();
    body.write_bytes = 1 << 20;
    const auto start = Clock::now();
    tus(connection,
        account,
        "PATCH",
        path,
        {{"Content-Type", "application/offset+octet-stream"}, {"Upload-Offset", "0"}},
        &body);
    if (durable == Durable::Synced) ::sync();
    const double seconds = seconds_since(start);
    tus(connection, account, "DELETE", path, {});
    return seconds;
}

// What the folder's disk takes: the same bytes by dd, made durable.
double seconds_of_dd(const fs::path& folder, std::int64_t size_bytes) {
    const fs::path input = "/dev/shm/divemesh-bench-" + std::to_string(getpid());
    const fs::path output = folder / "dd";
    {
        Noise noise(size_bytes);
        std::ofstream file(input, std::ios::binary);
        std::vector<char> buffer(kMebibyte);
        for (std::int64_t at = 0; at < size_bytes;) {
            const auto n = noise.read_at(at, buffer);
            file.write(buffer.data(), static_cast<std::streamsize>(n));
            at += static_cast<std::int64_t>(n);
        }
    }
    const auto start = Clock::now();
    const std::string command =
        "dd if=" + input.string() + " of=" + output.string() + " bs=4M conv=fsync status=none";
    const int failed = std::system(command.c_str());
    const double seconds = seconds_since(start);
    fs::remove(input);
    fs::remove(output);
    if (failed != 0) throw std::runtime_error("dd failed");
    return seconds;
}

json measure_patch(const Options& options, const fs::path& folder) {
    constexpr std::int64_t kSize = 512 * kMebibyte;
    const ServerUnderTest server(options, folder);
    CountingSink sink;
    const auto reference = TusReferenceServer::start(folder / "reference");
    Noise noise(kSize);
    std::vector<double> ours, dd, bare, theirs;
    for (int i = 0; i < options.num_repeats; ++i) {
        dd.push_back(seconds_of_dd(folder, kSize));
        bare.push_back(seconds_of_patch(server.account(sink.port()), noise));
        ours.push_back(seconds_of_patch(server.account(server.port()), noise));
        if (reference)
            theirs.push_back(
                seconds_of_patch(server.account(reference->port()), noise, Durable::Synced));
    }
    const double bytes = static_cast<double>(kSize) / 1e6;
    const double slower = std::max(stats::upper_median(dd), stats::upper_median(bare));
    json report = {{"bytes", kSize},
                   {"divemesh_mb_per_s", bytes / stats::upper_median(ours)},
                   {"dd_fsync_mb_per_s", bytes / stats::upper_median(dd)},
                   {"counting_sink_mb_per_s", bytes / stats::upper_median(bare)},
                   {"ratio_to_lower", slower / stats::upper_median(ours)},
                   {"seconds", {{"divemesh", ours}, {"dd", dd}, {"sink", bare}}}};
    report["tus_server_and_sync_mb_per_s"] =
        theirs.empty() ? json() : json(bytes / stats::upper_median(theirs));
    return report;
}

double seconds_of_upload(const client::Account& account,
                         std::int64_t size_bytes,
                         const fs::path& folder,
                         client::TusSettings settings = {}) {
    const TemporaryFolder state;
    Noise noise(size_bytes);
    const auto start = Clock::now();
    client::upload_by_tus(account,
                          noise,
                          {},
                          client::UploadState(state.path(), folder.string(), "noise"),
                          {},
                          settings);
    return seconds_since(start);
}

json measure_bad_link(const Options& options, const fs::path& folder, Cut cut) {
    constexpr std::int64_t kSize = 64 * kMebibyte;
    const ServerUnderTest server(options, folder);
    std::vector<double> wasted, ratios;
    int num_cuts = 0;
    for (int i = 0; i < options.num_repeats; ++i) {
        FlakyProxy good(server.port(), {.num_cuts = 0});
        FlakyProxy bad(server.port(), {.cut = cut, .cut_after_bytes = 10 * kMebibyte});
        const double usual = seconds_of_upload(server.account(good.port()), kSize, folder);
        const double hindered = seconds_of_upload(server.account(bad.port()), kSize, folder);
        num_cuts = bad.num_cuts();
        wasted.push_back((hindered - usual) / std::max(num_cuts, 1));
        ratios.push_back(static_cast<double>(bad.num_bytes()) / static_cast<double>(kSize));
    }
    return {{"bytes", kSize},
            {"cuts", num_cuts},
            {"wasted_s_per_cut", stats::upper_median(wasted)},
            {"bytes_sent_ratio", stats::upper_median(ratios)}};
}

// All of them are under way at once: a slow link each.
json measure_many(const Options& options, const fs::path& folder) {
    constexpr int kUploads = 100;
    constexpr std::int64_t kSize = 8 * kMebibyte;
    const ServerUnderTest server(options, folder);
    client::TusSettings settings;
    settings.max_bytes_per_s = 2e6;
    std::vector<std::jthread> threads;
    std::atomic<int> num_failed = 0;
    for (int i = 0; i < kUploads; ++i)
        threads.emplace_back([&] {
            try {
                seconds_of_upload(server.account(server.port()), kSize, folder, settings);
            } catch (const std::exception& error) {
                std::cerr << error.what() << std::endl;
                ++num_failed;
            }
        });
    threads.clear();
    return {{"uploads", kUploads},
            {"bytes_each", kSize},
            {"failed", num_failed.load()},
            {"server_peak_memory_mib", server.peak_memory_mib()}};
}

// A dive of 10 GB, nearly all of it holes, by the program itself over a link that breaks.
json measure_large(const Options& options, const fs::path& folder) {
    const ServerUnderTest server(options, folder);
    fs::create_directories(folder / "dive/mav0/cam0/data");
    std::ofstream(folder / "dive/mav0/cam0/data.csv") << "1,1.png\n";
    const fs::path sparse = folder / "dive/mav0/cam0/data/1.png";
    std::ofstream(sparse) << "first";
    fs::resize_file(sparse, 10'000'000'000);
    std::ofstream(sparse, std::ios::app) << "last";
    FlakyProxy proxy(server.port(), {.cut = Cut::HalfOpen, .cut_after_bytes = 700 * kMebibyte});
    const auto start = Clock::now();
    Process upload({options.program.string(),
                    "upload",
                    (folder / "dive").string(),
                    "--no-job",
                    "--json",
                    "--server",
                    "http://127.0.0.1:" + std::to_string(proxy.port())},
                   folder,
                   {{"DIVEMESH_TOKEN", server.token()}, {"XDG_STATE_HOME", folder.string()}});
    const auto exit_code = upload.wait(1200s);
    const auto answer = json::parse(upload.stdout_text(), nullptr, false);
    const bool verified = answer.is_object() && answer.value("verified", false);
    if (!verified) std::cerr << upload.stderr_text() << std::endl;
    return {{"bytes", 10'000'000'000},
            {"exit_code", exit_code.value_or(-1)},
            {"verified", verified},
            {"cuts", proxy.num_cuts()},
            {"bytes_sent_ratio", static_cast<double>(proxy.num_bytes()) / 1e10},
            {"seconds", seconds_since(start)},
            {"server_peak_memory_mib", server.peak_memory_mib()}};
}

json goal(const std::string& name, double value, bool at_most, double bound) {
    return {{"metric", name},
            {"value", value},
            {at_most ? "at_most" : "at_least", bound},
            {"met", at_most ? value <= bound : value >= bound}};
}

json measure(const Options& options) {
    const TemporaryFolder temporary;
    const auto folder = [&](const char* name) {
        const fs::path made = (options.folder.empty() ? temporary.path() : options.folder) / name;
        fs::remove_all(made);
        fs::create_directories(made);
        return made;
    };
    json report = {{"machine", describe_machine()}};
    report["patch"] = measure_patch(options, folder("patch"));
    report["half_open"] = measure_bad_link(options, folder("half_open"), Cut::HalfOpen);
    report["reset"] = measure_bad_link(options, folder("reset"), Cut::Reset);
    report["many"] = measure_many(options, folder("many"));
    auto& goals = report["goals"] = json::array();
    goals.push_back(goal("patch.ratio_to_lower", report["patch"]["ratio_to_lower"], false, 0.8));
    goals.push_back(
        goal("half_open.wasted_s_per_cut", report["half_open"]["wasted_s_per_cut"], true, 1.0));
    goals.push_back(
        goal("half_open.bytes_sent_ratio", report["half_open"]["bytes_sent_ratio"], true, 1.2));
    goals.push_back(
        goal("many.server_peak_memory_mib", report["many"]["server_peak_memory_mib"], true, 200));
    goals.push_back(goal("many.failed", report["many"]["failed"], true, 0));
    if (!options.large) return report;
    report["large"] = measure_large(options, folder("large"));
    goals.push_back(goal("large.verified", report["large"]["verified"] ? 1 : 0, false, 1));
    goals.push_back(
        goal("large.server_peak_memory_mib", report["large"]["server_peak_memory_mib"], true, 200));
    return report;
}

}  // namespace
}  // namespace divemesh::bench

int main(int argc, char** argv) {
    using namespace divemesh;
    bench::Options options;
    CLI::App app{"Measures uploads and prints the metrics as one JSON document."};
    app.add_option("--program", options.program, "path of the divemesh program")->required();
    app.add_option(
        "--folder", options.folder, "folder for the server's data; default: a temporary one");
    app.add_option("--repeat", options.num_repeats, "number of runs; takes their median")
        ->check(CLI::Range(1, 100));
    app.add_flag("--large", options.large, "also upload a dive of 10 GB");
    app.add_flag("--require", options.require, "exit with 3 if a goal is not met");
    CLI11_PARSE(app, argc, argv);
    const auto report = bench::measure(options);
    std::cout << report.dump(2) << "\n";
    for (const auto& goal : report["goals"])
        if (options.require && !goal["met"].get<bool>()) return 3;
    return 0;
}
