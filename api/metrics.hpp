#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "api/http.hpp"
#include "api/routes.hpp"
#include "storage/statistics.hpp"

namespace divemesh::api {

// A histogram with fixed upper bounds. Thread-safe.
class Histogram {
public:
    // `bounds` are in ascending order and outlive the histogram.
    explicit Histogram(std::span<const double> bounds)
        : bounds_(bounds), counts_(bounds.size() + 1) {}

    void observe(double value);
    // Appends lines of Prometheus' text format; `labels` is "a=\"b\"" or "".
    void append(std::string& text, const std::string& name, const std::string& labels) const;
    std::int64_t count() const;

private:
    std::span<const double> bounds_;
    std::vector<std::atomic<std::int64_t>> counts_;  // the last one: above all bounds
    std::atomic<double> sum_ = 0.0;
};

inline constexpr std::array<double, 12> kRequestBounds_s = {
    0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 1.0, 5.0, 30.0, 300.0};
inline constexpr std::array<double, 8> kUploadBounds_bytes = {
    1e4, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12};

// What the process has counted since it started, and the text that Prometheus reads (0.0.4).
// Thread-safe.
class Metrics {
public:
    Metrics() : routes_(routes().size() + 1) {}

    // `route` null: no route matched.
    void count_request(const Route* route, http::status status, std::chrono::nanoseconds took);

    std::atomic<std::int64_t> received_bytes = 0;  // of request bodies
    std::atomic<std::int64_t> sent_bytes = 0;      // of response bodies
    std::atomic<std::int64_t> connections = 0;     // open now
    std::atomic<std::int64_t> refused_connections = 0;
    std::atomic<std::int64_t> watchers = 0;  // event streams open now
    std::atomic<std::int64_t> serialised_events = 0;
    std::atomic<std::int64_t> dropped_watchers = 0;  // that fell silent or did not read
    std::atomic<std::int64_t> sensor_streams = 0;    // open now
    std::atomic<std::int64_t> sensor_messages = 0;   // new ones only
    std::atomic<std::int64_t> refused_frames = 0;    // of sensors' streams
    std::atomic<std::int64_t> webhook_failures = 0;
    Histogram uploaded_bytes{kUploadBounds_bytes};  // of completed uploads
    Histogram resumed_bytes{kUploadBounds_bytes};   // already stored when a client resumed

    std::string text(const storage::Statistics& stored, std::int64_t free_bytes) const;

private:
    struct OfRoute {
        Histogram seconds{kRequestBounds_s};
        std::array<std::atomic<std::int64_t>, 6> by_class = {};  // [2]: 2xx
    };

    void append_requests(std::string& text) const;
    void append_numbers(std::string& text,
                        const storage::Statistics& stored,
                        std::int64_t free_bytes) const;

    std::vector<OfRoute> routes_;  // the last one: no route
};

}  // namespace divemesh::api
