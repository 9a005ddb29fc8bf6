#include "api/sensors/sensor_hub.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "api/http.hpp"
#include "schemas/merge_patch.hpp"
#include "schemas/wall_clock.hpp"

namespace divemesh::api {
namespace {

using nlohmann::json;

json document_of(const Sensor& sensor) {
    json document = sensor;
    document.erase("status_age_ms");
    return without_nulls(std::move(document));
}

json frame_of(const SensorSnapshot& snapshot, std::string_view type) {
    return {{"type", type},
            {"sensor", snapshot.sensor},
            {"revision", snapshot.revision},
            {"time_ms", snapshot.time_ms}};
}

}  // namespace

std::string snapshot_text(const SensorSnapshot& snapshot) {
    json frame = frame_of(snapshot, "sensor.snapshot");
    frame["data"] = snapshot.document;
    return json_text(frame);
}

std::string delta_text(const SensorSnapshot& sent, const SensorSnapshot& snapshot) {
    json frame = frame_of(snapshot, "sensor.delta");
    frame["previous"] = sent.revision;
    frame["patch"] = merge_patch(sent.document, snapshot.document);
    return json_text(frame);
}

// The caller holds the lock, as for every private function.
void SensorHub::renew(Entry& entry, std::int64_t now) {
    json document = document_of(as_of(entry.sensor, now));
    if (entry.snapshot && entry.snapshot->document == document) return;
    auto snapshot = std::make_shared<SensorSnapshot>();
    snapshot->sensor = entry.sensor.id;
    snapshot->project = entry.sensor.project;
    snapshot->time_ms = now;
    snapshot->document = std::move(document);
    snapshot->revision = now;
    if (entry.snapshot) {
        snapshot->revision = std::max(now, entry.snapshot->revision + 1);
        snapshot->previous = entry.snapshot->revision;
        if (!entry.watchers.empty()) snapshot->delta = delta_text(*entry.snapshot, *snapshot);
    }
    entry.snapshot = std::move(snapshot);
    for (const auto& [watcher, on_change] : entry.watchers) on_change();
}

void SensorHub::publish(const Sensor& sensor) {
    const std::lock_guard lock(mutex_);
    Entry& entry = entries_[sensor.id];
    if (entry.snapshot && sensor.seen_at_ms < entry.sensor.seen_at_ms) return;
    entry.sensor = sensor;
    renew(entry, wall_time_ms());
}

void SensorHub::introduce(const Sensor& sensor) {
    const std::lock_guard lock(mutex_);
    Entry& entry = entries_[sensor.id];
    if (entry.snapshot) return;
    entry.sensor = sensor;
    renew(entry, wall_time_ms());
}

void SensorHub::look_at_the_time() {
    const std::int64_t now = wall_time_ms();
    const std::lock_guard lock(mutex_);
    for (auto& [id, entry] : entries_)
        if (entry.snapshot) renew(entry, now);
}

std::shared_ptr<const SensorSnapshot> SensorHub::find(const std::string& sensor) const {
    const std::lock_guard lock(mutex_);
    const auto entry = entries_.find(sensor);
    return entry == entries_.end() ? nullptr : entry->second.snapshot;
}

std::uint64_t SensorHub::watch(const std::vector<std::string>& sensors,
                               std::function<void()> on_change) {
    const std::lock_guard lock(mutex_);
    const std::uint64_t watcher = next_++;
    for (const std::string& sensor : sensors) entries_[sensor].watchers.emplace(watcher, on_change);
    watched_.emplace(watcher, sensors);
    return watcher;
}

void SensorHub::unwatch(std::uint64_t watcher) {
    const std::lock_guard lock(mutex_);
    const auto watched = watched_.find(watcher);
    for (const std::string& sensor : watched->second) entries_[sensor].watchers.erase(watcher);
    watched_.erase(watched);
}

std::uint64_t SensorHub::connect(const std::string& sensor, Line line) {
    const std::lock_guard lock(mutex_);
    const auto before = connections_.find(sensor);
    if (before != connections_.end()) before->second.line.end();
    const std::uint64_t number = next_++;
    connections_.insert_or_assign(sensor, Connection{number, std::move(line)});
    return number;
}

void SensorHub::disconnect(const std::string& sensor, std::uint64_t connection) {
    const std::lock_guard lock(mutex_);
    const auto known = connections_.find(sensor);
    if (known != connections_.end() && known->second.number == connection)
        connections_.erase(known);
}

void SensorHub::call(const std::string& sensor) {
    const std::lock_guard lock(mutex_);
    const auto known = connections_.find(sensor);
    if (known != connections_.end()) known->second.line.wake();
}

}  // namespace divemesh::api
