// divemesh_s3_bench --program FILE [--mebibytes N] [--repeat N] [--require]: how fast and how
// sparing dives reach an object store (Ceph, on loopback), beside rclone and s3cmd in the same run,
// as one JSON. Exit 3 when --require is given and a goal is not met.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "api/client/tus_upload.hpp"
#include "storage/s3_blob_store.hpp"
#include "tests/bench/machine.hpp"
#include "tests/bench/process_usage.hpp"
#include "tests/bench/served.hpp"
#include "tests/storage/faulty_gateway.hpp"
#include "tests/storage/s3_server.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::bench {
namespace {

namespace client = api::client;
namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using json = nlohmann::json;
using namespace std::chrono_literals;

struct Options {
    fs::path program;
    std::int64_t num_mebibytes = 512;
    int num_repeats = 3;
    bool require = false;
};

// Writes noise, which no store can make smaller.
void write_noise(const fs::path& path, std::int64_t num_mebibytes) {
    std::ofstream file(path, std::ios::binary);
    std::vector<std::uint64_t> block((1 << 20) / sizeof(std::uint64_t));
    std::uint64_t state = 1;
    for (std::int64_t i = 0; i < num_mebibytes; ++i) {
        for (std::uint64_t& word : block) {
            state = state * 6364136223846793005U + 1442695040888963407U;
            word = state ^ (state >> 29);
        }
        file.write(reinterpret_cast<const char*>(block.data()), 1 << 20);
    }
}

double seconds_of(const std::function<void()>& work) {
    const auto start = Clock::now();
    work();
    return std::chrono::duration<double>(Clock::now() - start).count();
}

class Bench {
public:
    explicit Bench(const Options& options)
        : options_(options), store_(storage::S3Server::start_ceph(32)) {
        if (!store_) throw std::runtime_error("Ceph is not installed: deploy/install.sh --full");
        write_noise(file_, options.num_mebibytes);
        fs::create_directories(folder_ / "served");
    }

    json measure() {
        json report = {{"machine", describe_machine()},
                       {"bytes", fs::file_size(file_)},
                       {"speed", measure_speed()},
                       {"traffic", measure_traffic()}};
        report["goals"] = {
            goal("speed.ratio_to_fastest", report["speed"]["ratio_to_fastest"], false, 0.8),
            goal("traffic.sent_ratio", report["traffic"]["sent_ratio"], true, 1.02),
            goal("traffic.fetched_ratio", report["traffic"]["fetched_ratio"], true, 1.1)};
        return report;
    }

private:
    static json goal(const char* metric, const json& value, bool at_most, double bound) {
        const bool met = at_most ? value.get<double>() <= bound : value.get<double>() >= bound;
        return {{"metric", metric},
                {"value", value},
                {at_most ? "at_most" : "at_least", bound},
                {"met", met}};
    }

    std::string endpoint() const { return "http://127.0.0.1:" + std::to_string(store_->port()); }
    Process::Environment keys() const {
        return {{"AWS_ACCESS_KEY_ID", store_->credentials().access_key},
                {"AWS_SECRET_ACCESS_KEY", store_->credentials().secret_key}};
    }

    void run(const std::vector<std::string>& command, const Process::Environment& environment) {
        Process process(command, folder_.path(), environment);
        if (process.wait(600s) != 0)
            throw std::runtime_error(command.front() + ": " + process.stderr_text());
    }

    // With its own choice of parts and connections.
    double seconds_of_rclone() {
        return seconds_of([&] {
            run({"/usr/bin/rclone", "copyto", file_.string(), "ceph:dives/rclone/" + next_name()},
                {{"RCLONE_CONFIG", (folder_ / "rclone.conf").string()},
                 {"RCLONE_CONFIG_CEPH_TYPE", "s3"},
                 {"RCLONE_CONFIG_CEPH_PROVIDER", "Ceph"},
                 {"RCLONE_CONFIG_CEPH_ENDPOINT", endpoint()},
                 {"RCLONE_CONFIG_CEPH_ACCESS_KEY_ID", store_->credentials().access_key},
                 {"RCLONE_CONFIG_CEPH_SECRET_ACCESS_KEY", store_->credentials().secret_key}});
        });
    }
    double seconds_of_s3cmd() {
        const std::string host = "127.0.0.1:" + std::to_string(store_->port());
        return seconds_of([&] {
            run({"/usr/bin/s3cmd",
                 "--config=/dev/null",
                 "--no-ssl",
                 "--no-progress",
                 "--access_key=" + store_->credentials().access_key,
                 "--secret_key=" + store_->credentials().secret_key,
                 "--host=" + host,
                 "--host-bucket=" + host,
                 "put",
                 file_.string(),
                 "s3://dives/s3cmd/" + next_name()},
                {});
        });
    }
    // From its first byte until it is a dive whose archive is in the object store.
    double seconds_of_server(const Served& server) {
        const TemporaryFolder state;
        client::FileSource source(file_);
        std::string token;
        std::ifstream(folder_ / "served/data/admin.token") >> token;
        const client::Account account{client::parse_server_url(server.address()), token};
        return seconds_of([&] {
            client::upload_by_tus(account,
                                  source,
                                  {{"commit", "bench"}, {"filename", next_name()}},
                                  client::UploadState(state.path(), folder_.path().string(), "x"),
                                  {},
                                  {.stall = 600s});
        });
    }

    // One after the other, so that all have the same share of a busy machine.
    json measure_speed() {
        const Served server(
            options_.program, folder_ / "served/data", {"--blobs", store_->url("served")}, keys());
        const auto blobs = open_s3_blob_store(
            storage::parse_s3_url(store_->url("direct")), store_->credentials(), {});
        std::vector<double> rclone, s3cmd, direct, ours, ratios;
        for (int i = 0; i < options_.num_repeats; ++i) {
            rclone.push_back(seconds_of_rclone());
            s3cmd.push_back(seconds_of_s3cmd());
            direct.push_back(seconds_of([&] { blobs->put_file("dives/x", file_); }));
            ours.push_back(seconds_of_server(server));
            ratios.push_back(std::min(rclone.back(), s3cmd.back()) / ours.back());
        }
        const double megabytes = static_cast<double>(fs::file_size(file_)) / 1e6;
        const auto rate = [&](const std::vector<double>& seconds) {
            return megabytes / stats::upper_median(seconds);
        };
        return {{"rclone_mb_per_s", rate(rclone)},
                {"s3cmd_mb_per_s", rate(s3cmd)},
                {"store_mb_per_s", rate(direct)},
                {"server_mb_per_s", rate(ours)},
                {"ratio_to_fastest", stats::upper_median(ratios)},
                {"seconds",
                 {{"rclone", rclone}, {"s3cmd", s3cmd}, {"store", direct}, {"server", ours}}},
                {"server_peak_memory_mib",
                 static_cast<double>(peak_memory_bytes_of(server.pid())) / 1048576.0}};
    }

    // What one dive sends to the store, and one worker's copy fetches from it.
    json measure_traffic() {
        const storage::FaultyGateway gateway(store_->port());
        const auto location = storage::parse_s3_url(store_->url("traffic", gateway.port()));
        const auto blobs = open_s3_blob_store(location, store_->credentials(), folder_ / "staged");
        const fs::path staged = folder_ / "staged/uploads/u";
        fs::create_directories(staged.parent_path());
        fs::copy_file(file_, staged);
        blobs->commit_staged("uploads/u", "dives/u/archive");
        const std::int64_t sent = gateway.num_bytes_sent();
        const std::int64_t before = gateway.num_bytes_received();
        blobs->local_copy("dives/u/archive", folder_ / "copy");
        const double size = static_cast<double>(fs::file_size(file_));
        return {
            {"sent_ratio", static_cast<double>(sent) / size},
            {"fetched_ratio", static_cast<double>(gateway.num_bytes_received() - before) / size}};
    }

    std::string next_name() { return std::to_string(num_names_++); }

    Options options_;
    std::unique_ptr<storage::S3Server> store_;
    TemporaryFolder folder_;
    fs::path file_ = folder_ / "noise";
    int num_names_ = 0;
};

}  // namespace
}  // namespace divemesh::bench

int main(int argc, char** argv) {
    using namespace divemesh;
    bench::Options options;
    CLI::App app{"Measures blobs in an object store and prints the metrics as one JSON document."};
    app.add_option("--program", options.program, "path of the divemesh program")->required();
    app.add_option("--mebibytes", options.num_mebibytes, "size of the dive")
        ->check(CLI::Range(1, 4096));
    app.add_option("--repeat", options.num_repeats, "number of runs; takes their median")
        ->check(CLI::Range(1, 100));
    app.add_flag("--require", options.require, "exit with 3 if a goal is not met");
    CLI11_PARSE(app, argc, argv);
    try {
        const auto report = bench::Bench(options).measure();
        std::cout << report.dump(2) << "\n";
        for (const auto& goal : report["goals"])
            if (options.require && !goal["met"].get<bool>()) return 3;
        return 0;
    } catch (const std::exception& error) {
        std::cerr << error.what() << std::endl;
        return 1;
    }
}
