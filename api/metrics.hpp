#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "api/http.hpp"
#include "api/routes.hpp"
#include "storage/statistics.hpp"

namespace divemesh::api {

// Counts how long things took, by upper bounds in seconds. Thread-safe.
class Histogram {
public:
    static constexpr std::array<double, 12> kBounds = {
        0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 1.0, 5.0, 30.0, 300.0};

    void observe(std::chrono::nanoseconds took);
    // Lines of Prometheus' text format; `labels` is "a=\"b\"" or "".
    void append(std::string& text, const std::string& name, const std::string& labels) const;
    std::int64_t count() const;

private:
    std::array<std::atomic<std::int64_t>, kBounds.size() + 1> counts_ = {};
    std::atomic<std::int64_t> sum_ns_ = 0;
};

// What the process has counted since it started, and the text that Prometheus reads (0.0.4).
// Thread-safe.
class Metrics {
public:
    Metrics() : routes_(routes().size() + 1) {}

    // `route` null: no route fitted.
    void count_request(const Route* route, http::status status, std::chrono::nanoseconds took);

    std::atomic<std::int64_t> received_bytes = 0;  // of bodies
    std::atomic<std::int64_t> sent_bytes = 0;      // of answers' bodies
    std::atomic<std::int64_t> connections = 0;     // open now
    std::atomic<std::int64_t> refused_connections = 0;
    std::atomic<std::int64_t> watchers = 0;  // event streams open now
    std::atomic<std::int64_t> told_events = 0;
    std::atomic<std::int64_t> dropped_watchers = 0;  // that fell silent or did not read
    std::atomic<std::int64_t> webhook_failures = 0;

    std::string text(const storage::Statistics& stored, std::int64_t free_bytes) const;

private:
    struct OfRoute {
        Histogram seconds;
        std::array<std::atomic<std::int64_t>, 6> by_class = {};  // [2]: 2xx
    };
    std::vector<OfRoute> routes_;  // the last one: no route
};

}  // namespace divemesh::api
