// sensor_history [--sensors N] [--hours N]: what the history of sensors costs when it is full:
// statuses of every second, written in the order of time as group commits write them. Prints one
// JSON: how long one sensor's day takes, of five fields in 1,000 steps, and what a second of all
// sensors takes to write.
#include "storage/sensor_history.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <random>
#include <soci/soci.h>

#include "storage/catalog.hpp"
#include "storage/sensor_store.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::storage {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::int64_t kBegin_ms = 1'795'000'000'000;
constexpr int kSecondsTogether = 10;
constexpr int kNumReads = 25;
constexpr int kNumWrites = 25;

double ms_since(Clock::time_point began) {
    return std::chrono::duration<double, std::milli>(Clock::now() - began).count();
}

nlohmann::json summary(const std::vector<double>& times_ms) {
    return {{"median_ms", stats::upper_median(times_ms)},
            {"worst_ms", *std::max_element(times_ms.begin(), times_ms.end())}};
}

std::string name_of(int sensor) { return "rig-" + std::to_string(sensor); }

std::vector<IncomingReport> second_of_all(int num_sensors, int second) {
    std::vector<IncomingReport> reports;
    for (int sensor = 1; sensor <= num_sensors; ++sensor) {
        SensorMessage message{.sequence = second, .uptime_ms = 1000 * second};
        message.body = {{"recording", true},
                        {"battery", 0.7},
                        {"depth_m", 12.5},
                        {"temperature_c", 9.0},
                        {"orientation", {1.0, 0.0, 0.0, 0.0}}};
        reports.push_back({name_of(sensor), "default", {"boot", {message}, {}}});
    }
    return reports;
}

void fill(Catalog& catalog, int num_sensors, int num_seconds) {
    for (int second = 0; second < num_seconds; second += kSecondsTogether)
        catalog.transaction([&](soci::session& session) {
            session << "WITH RECURSIVE s(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM s WHERE i < "
                    << num_sensors << "), t(k) AS (SELECT " << second
                    << " UNION ALL SELECT k + 1 FROM t WHERE k < " << second + kSecondsTogether - 1
                    << ") INSERT INTO sensor_statuses (sensor, time_ms, boot, sequence, recording,"
                       " num_frames, frame_rate_hz, storage_free_bytes, battery, depth_m,"
                       " temperature_c, leak, humidity, imu_rate_hz, link_rssi_dbm, more)"
                       " SELECT i, "
                    << kBegin_ms
                    << " + 1000 * k, 1, k, 1, 10 * k, 9.8, 8e10 - 1e6 * k, 0.9 - k * 1e-6,"
                       " abs(random() % 3000) / 100.0, 8 + abs(random() % 100) / 100.0, 0, 0.31,"
                       " 200.1, -60 - abs(random() % 20), '{\"orientation\":[1.0,0.0,0.0,0.0]}'"
                       " FROM t, s";
        });
}

nlohmann::json measure(int num_sensors, int hours) {
    const TemporaryFolder folder;
    Catalog catalog("sqlite://" + (folder / "catalog.db").string());
    SensorStore sensors(catalog);
    sensors.receive(second_of_all(num_sensors, 0));
    const auto began = Clock::now();
    fill(catalog, num_sensors, hours * 3600);
    const double filled_s = ms_since(began) / 1000.0;

    std::mt19937 random(1);
    std::vector<double> reads_ms;
    for (int i = 0; i < kNumReads; ++i) {
        const int sensor = 1 + static_cast<int>(random() % static_cast<unsigned>(num_sensors));
        const auto asked = Clock::now();
        const auto history =
            read_history(catalog,
                         {name_of(sensor),
                          kBegin_ms,
                          kBegin_ms + std::int64_t{hours} * 3'600'000,
                          1000,
                          {"depth_m", "battery", "temperature_c", "humidity", "leak"}});
        reads_ms.push_back(ms_since(asked));
        if (history.steps.size() != 1000) throw std::runtime_error("not 1,000 steps");
    }
    std::vector<double> writes_ms;
    for (int i = 1; i <= kNumWrites; ++i) {
        const auto reports = second_of_all(num_sensors, i);
        const auto asked = Clock::now();
        sensors.receive(reports);
        writes_ms.push_back(ms_since(asked));
    }
    return {{"num_sensors", num_sensors},
            {"num_statuses", std::int64_t{num_sensors} * hours * 3600},
            {"catalog_bytes", std::filesystem::file_size(folder / "catalog.db")},
            {"filled_in_s", filled_s},
            {"day_of_one_sensor", summary(reads_ms)},
            {"second_of_all_sensors", summary(writes_ms)}};
}

}  // namespace
}  // namespace divemesh::storage

int main(int argc, char** argv) {
    CLI::App app("Measures reads and writes of a full history of sensors.");
    int num_sensors = 200;
    int hours = 24;
    app.add_option("--sensors", num_sensors)->check(CLI::Range(1, 10'000));
    app.add_option("--hours", hours)->check(CLI::Range(1, 240));
    CLI11_PARSE(app, argc, argv);
    std::cout << divemesh::storage::measure(num_sensors, hours).dump(2) << '\n';
}
