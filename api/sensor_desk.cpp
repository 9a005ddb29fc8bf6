#include "api/sensor_desk.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "api/http.hpp"
#include "api/wall_clock.hpp"
#include "schemas/merge_patch.hpp"

namespace divemesh::api {
namespace {

using nlohmann::json;

json document_of(const Sensor& sensor) {
    json document = sensor;
    document.erase("status_age_ms");
    return without_nulls(std::move(document));
}

json frame_of(const SensorNews& news, std::string_view type) {
    return {{"type", type},
            {"sensor", news.sensor},
            {"revision", news.revision},
            {"time_ms", news.time_ms}};
}

}  // namespace

std::string snapshot_text(const SensorNews& news) {
    json frame = frame_of(news, "sensor.snapshot");
    frame["data"] = news.document;
    return json_text(frame);
}

std::string delta_text(const SensorNews& told, const SensorNews& news) {
    json frame = frame_of(news, "sensor.delta");
    frame["previous"] = told.revision;
    frame["patch"] = merge_patch(told.document, news.document);
    return json_text(frame);
}

// Under the lock, like all that is private.
void SensorDesk::renew(Entry& entry, std::int64_t now) {
    json document = document_of(as_of(entry.sensor, now));
    if (entry.news && entry.news->document == document) return;
    auto news = std::make_shared<SensorNews>();
    news->sensor = entry.sensor.id;
    news->project = entry.sensor.project;
    news->time_ms = now;
    news->document = std::move(document);
    news->revision = now;
    if (entry.news) {
        news->revision = std::max(now, entry.news->revision + 1);
        news->previous = entry.news->revision;
        if (!entry.watchers.empty()) news->delta = delta_text(*entry.news, *news);
    }
    entry.news = std::move(news);
    for (const auto& [watcher, on_news] : entry.watchers) on_news();
}

void SensorDesk::publish(const Sensor& sensor) {
    const std::lock_guard lock(mutex_);
    Entry& entry = entries_[sensor.id];
    if (entry.news && sensor.seen_at_ms < entry.sensor.seen_at_ms) return;
    entry.sensor = sensor;
    renew(entry, now_ms());
}

void SensorDesk::introduce(const Sensor& sensor) {
    const std::lock_guard lock(mutex_);
    Entry& entry = entries_[sensor.id];
    if (entry.news) return;
    entry.sensor = sensor;
    renew(entry, now_ms());
}

void SensorDesk::look_at_the_time() {
    const std::int64_t now = now_ms();
    const std::lock_guard lock(mutex_);
    for (auto& [id, entry] : entries_)
        if (entry.news) renew(entry, now);
}

std::shared_ptr<const SensorNews> SensorDesk::find(const std::string& sensor) const {
    const std::lock_guard lock(mutex_);
    const auto entry = entries_.find(sensor);
    return entry == entries_.end() ? nullptr : entry->second.news;
}

std::uint64_t SensorDesk::watch(const std::vector<std::string>& sensors,
                                std::function<void()> on_news) {
    const std::lock_guard lock(mutex_);
    const std::uint64_t watcher = next_++;
    for (const std::string& sensor : sensors) entries_[sensor].watchers.emplace(watcher, on_news);
    watched_.emplace(watcher, sensors);
    return watcher;
}

void SensorDesk::unwatch(std::uint64_t watcher) {
    const std::lock_guard lock(mutex_);
    const auto watched = watched_.find(watcher);
    for (const std::string& sensor : watched->second) entries_[sensor].watchers.erase(watcher);
    watched_.erase(watched);
}

std::uint64_t SensorDesk::connect(const std::string& sensor, Line line) {
    const std::lock_guard lock(mutex_);
    const auto before = connections_.find(sensor);
    if (before != connections_.end()) before->second.line.end();
    const std::uint64_t number = next_++;
    connections_.insert_or_assign(sensor, Connection{number, std::move(line)});
    return number;
}

void SensorDesk::disconnect(const std::string& sensor, std::uint64_t connection) {
    const std::lock_guard lock(mutex_);
    const auto known = connections_.find(sensor);
    if (known != connections_.end() && known->second.number == connection)
        connections_.erase(known);
}

void SensorDesk::call(const std::string& sensor) {
    const std::lock_guard lock(mutex_);
    const auto known = connections_.find(sensor);
    if (known != connections_.end()) known->second.line.wake();
}

}  // namespace divemesh::api
