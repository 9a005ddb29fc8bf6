#include "api/metrics.hpp"

#include <algorithm>
#include <charconv>

namespace divemesh::api {
namespace {

std::string number_text(double value) {
    char text[32];
    const auto [end, failure] = std::to_chars(text, text + sizeof text, value);
    return failure == std::errc() ? std::string(text, end) : "NaN";
}

std::string in_braces(const std::string& labels) {
    return labels.empty() ? "" : "{" + labels + "}";
}

void begin(std::string& text, const std::string& name, const char* type, const char* help) {
    text += "# HELP " + name + " " + help + "\n# TYPE " + name + " " + type + "\n";
}

void append(std::string& text, const std::string& name, const std::string& labels, double value) {
    text += name + in_braces(labels) + " " + number_text(value) + "\n";
}

void append_one(
    std::string& text, const std::string& name, const char* type, const char* help, double value) {
    begin(text, name, type, help);
    append(text, name, "", value);
}

std::string labels_of(std::span<const Route> all, std::size_t index) {
    if (index == all.size()) return R"(method="",route="")";
    return "method=\"" + std::string(http::to_string(all[index].method)) + "\",route=\"" +
           std::string(all[index].path) + "\"";
}

// The last of `counts` is for values above all bounds.
template <typename Counts>
void append_histogram(std::string& text,
                      const std::string& name,
                      const std::string& labels,
                      std::span<const double> bounds,
                      const Counts& counts,
                      double sum) {
    const std::string bucket = name + "_bucket{" + labels + (labels.empty() ? "" : ",") + "le=\"";
    const auto bound_text = [&](std::size_t i) {
        return i < bounds.size() ? number_text(bounds[i]) : "+Inf";
    };
    std::int64_t below = 0;
    for (std::size_t i = 0; i < counts.size(); ++i) {
        below += counts[i];
        text += bucket + bound_text(i) + "\"} " + std::to_string(below) + "\n";
    }
    append(text, name + "_sum", labels, sum);
    text += name + "_count" + in_braces(labels) + " " + std::to_string(below) + "\n";
}

void append_stages(std::string& text, const std::vector<storage::StageSeconds>& stages) {
    begin(text,
          "divemesh_stage_seconds",
          "histogram",
          "seconds spent in stages of jobs, over all attempts, without stages from the cache");
    for (const auto& stage : stages)
        append_histogram(text,
                         "divemesh_stage_seconds",
                         "stage=\"" + stage.stage + "\"",
                         storage::kStageBounds_s,
                         stage.num_runs,
                         stage.total_s);
    begin(text, "divemesh_stages_cached_total", "counter", "stages taken from the cache");
    for (const auto& stage : stages)
        append(text,
               "divemesh_stages_cached_total",
               "stage=\"" + stage.stage + "\"",
               static_cast<double>(stage.num_cached));
}

void append_counts(std::string& text,
                   const std::string& name,
                   const char* help,
                   const storage::Statistics::Counts& counts) {
    begin(text, name, "gauge", help);
    for (const auto& [state, count] : counts)
        append(text, name, "state=\"" + state + "\"", static_cast<double>(count));
}

}  // namespace

void Histogram::observe(double value) {
    const auto bound = std::lower_bound(bounds_.begin(), bounds_.end(), value);
    counts_[static_cast<std::size_t>(bound - bounds_.begin())]++;
    sum_ += value;
}

std::int64_t Histogram::count() const {
    std::int64_t all = 0;
    for (const auto& count : counts_) all += count;
    return all;
}

void Histogram::append(std::string& text,
                       const std::string& name,
                       const std::string& labels) const {
    append_histogram(text, name, labels, bounds_, counts_, sum_);
}

void Metrics::count_request(const Route* route,
                            http::status status,
                            std::chrono::nanoseconds took) {
    const auto all = routes();
    const auto index = route == nullptr ? all.size() : static_cast<std::size_t>(route - all.data());
    routes_[index].seconds.observe(std::chrono::duration<double>(took).count());
    routes_[index].by_class[std::min<std::size_t>(static_cast<unsigned>(status) / 100, 5)]++;
}

std::string Metrics::text(const storage::Statistics& stored, std::int64_t free_bytes) const {
    std::string text;
    append_requests(text);
    begin(
        text, "divemesh_upload_bytes", "histogram", "bytes of completed uploads, including parts");
    uploaded_bytes.append(text, "divemesh_upload_bytes", "");
    begin(text,
          "divemesh_upload_resumed_bytes",
          "histogram",
          "bytes that a resuming client did not have to send again");
    resumed_bytes.append(text, "divemesh_upload_resumed_bytes", "");
    append_stages(text, stored.stages);
    append_numbers(text, stored, free_bytes);
    append_counts(text, "divemesh_jobs", "jobs by state", stored.jobs);
    append_counts(text, "divemesh_dives", "dives by state", stored.dives);
    append_counts(text, "divemesh_attempts", "attempts by their outcome", stored.attempts);
    append_counts(text,
                  "divemesh_attempts_milliseconds",
                  "milliseconds spent in attempts",
                  stored.attempt_ms);
    return text;
}

void Metrics::append_requests(std::string& text) const {
    const auto all = routes();
    begin(text, "divemesh_http_requests_total", "counter", "answers by route and class of status");
    for (std::size_t i = 0; i < routes_.size(); ++i)
        for (std::size_t c = 1; c < routes_[i].by_class.size(); ++c)
            if (routes_[i].by_class[c] > 0)
                append(text,
                       "divemesh_http_requests_total",
                       labels_of(all, i) + ",status=\"" + std::to_string(c) + "xx\"",
                       static_cast<double>(routes_[i].by_class[c]));
    begin(text,
          "divemesh_http_request_seconds",
          "histogram",
          "seconds from the request's header to the answer");
    for (std::size_t i = 0; i < routes_.size(); ++i)
        if (routes_[i].seconds.count() > 0)
            routes_[i].seconds.append(text, "divemesh_http_request_seconds", labels_of(all, i));
}

void Metrics::append_numbers(std::string& text,
                             const storage::Statistics& stored,
                             std::int64_t free_bytes) const {
    const struct {
        const char* name;
        const char* type;
        const char* help;
        std::int64_t value;
    } singles[] = {
        // clang-format off
        {"divemesh_http_received_bytes_total", "counter", "bytes of request bodies", received_bytes},
        {"divemesh_http_sent_bytes_total", "counter", "bytes of answer bodies", sent_bytes},
        {"divemesh_connections", "gauge", "open connections", connections},
        {"divemesh_connections_refused_total", "counter", "connections refused because there were too many", refused_connections},
        {"divemesh_event_streams", "gauge", "open event streams", watchers},
        {"divemesh_events_told_total", "counter", "frames sent to event streams", serialised_events},
        {"divemesh_event_streams_dropped_total", "counter", "event streams closed because the client did not read or answer", dropped_watchers},
        {"divemesh_sensor_streams", "gauge", "open streams of sensors", sensor_streams},
        {"divemesh_sensor_messages_total", "counter", "new messages of sensors, stored durably", sensor_messages},
        {"divemesh_sensor_frames_refused_total", "counter", "refused frames on streams of sensors", refused_frames},
        {"divemesh_webhook_failures_total", "counter", "failed attempts to deliver a webhook", webhook_failures},
        {"divemesh_webhook_deliveries_waiting", "gauge", "webhook deliveries in the outbox", stored.deliveries_waiting},
        {"divemesh_uploads_open", "gauge", "incomplete uploads", stored.uploads_open},
        {"divemesh_uploads_open_bytes", "gauge", "bytes received of incomplete uploads", stored.uploads_open_bytes},
        {"divemesh_archive_bytes", "gauge", "bytes of the archives of all dives", stored.archive_bytes},
        {"divemesh_artifact_bytes", "gauge", "bytes of all artifacts", stored.artifact_bytes},
        {"divemesh_disk_free_bytes", "gauge", "free bytes on the disk of the blobs", free_bytes},
        // clang-format on
    };
    for (const auto& single : singles)
        append_one(text, single.name, single.type, single.help, static_cast<double>(single.value));
    append_one(text,
               "divemesh_queue_oldest_seconds",
               "gauge",
               "seconds that the oldest job that could run has waited",
               1e-3 * static_cast<double>(stored.oldest_queued_ms));
    append_one(text,
               "divemesh_lease_oldest_seconds",
               "gauge",
               "seconds since the lease that is most overdue should have ended; negative: no lease "
               "is overdue",
               1e-3 * static_cast<double>(stored.lease_overdue_ms));
}

}  // namespace divemesh::api
