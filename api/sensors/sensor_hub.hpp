#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "schemas/sensor.hpp"

namespace divemesh::api {

// A sensor as its watchers see it: its resource without the age, which changes at every moment.
struct SensorSnapshot {
    std::string sensor;
    std::string project;
    std::int64_t revision = 0;  // rises, also across a restart
    std::int64_t previous = 0;  // the revision that `delta` starts from; 0: no delta
    std::int64_t time_ms = 0;   // of this state
    nlohmann::json document;
    std::string delta;  // the text frame, the same for all watchers that have `previous`
};

// Return the text frames: the whole snapshot, and what has changed since `sent` (RFC 7396).
std::string snapshot_text(const SensorSnapshot& snapshot);
std::string delta_text(const SensorSnapshot& sent, const SensorSnapshot& snapshot);

// The current state of the sensors, in memory. A device's report reaches its watchers through it
// once it is durable. Only the newest state counts; there are no queues. Thread-safe.
class SensorHub {
public:
    // Takes the sensor's state and wakes its watchers. An older state than the known one changes
    // nothing.
    void publish(const Sensor& sensor);
    // Takes the catalog's state of a sensor that is about to be watched. If the sensor is known
    // already, nothing changes.
    void introduce(const Sensor& sensor);
    // Updates what only time changes of the known sensors.
    void look_at_the_time();

    std::shared_ptr<const SensorSnapshot> find(const std::string& sensor) const;  // null: unknown

    // Calls `on_change`, on any thread, whenever one of the sensors changes, until unwatch().
    std::uint64_t watch(const std::vector<std::string>& sensors, std::function<void()> on_change);
    void unwatch(std::uint64_t watcher);

    // The one stream of a sensor. `wake` is called when there is work for it, `end` when another
    // stream of the same sensor takes its place. Both are called on any thread.
    struct Line {
        std::function<void()> wake;
        std::function<void()> end;
    };
    std::uint64_t connect(const std::string& sensor, Line line);
    void disconnect(const std::string& sensor, std::uint64_t connection);
    void call(const std::string& sensor);  // wakes its stream, if it has one

private:
    struct Entry {
        Sensor sensor;
        std::shared_ptr<const SensorSnapshot> snapshot;
        std::map<std::uint64_t, std::function<void()>> watchers;
    };
    struct Connection {
        std::uint64_t number = 0;
        Line line;
    };

    void renew(Entry& entry, std::int64_t now_ms);

    mutable std::mutex mutex_;
    std::map<std::string, Entry> entries_;
    std::map<std::uint64_t, std::vector<std::string>> watched_;
    std::map<std::string, Connection> connections_;
    std::uint64_t next_ = 1;
};

}  // namespace divemesh::api
