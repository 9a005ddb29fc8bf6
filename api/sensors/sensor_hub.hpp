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

// A sensor as those who watch it are told: its resource without the age, which is another at each
// moment.
struct SensorSnapshot {
    std::string sensor;
    std::string project;
    std::int64_t revision = 0;  // rises, also over a restart
    std::int64_t previous = 0;  // the revision that `delta` goes on from; 0: there is none
    std::int64_t time_ms = 0;   // when it was so
    nlohmann::json document;
    std::string delta;  // the frame of text, the same for all who have the previous one
};

// The frames of text: all of it, and what has changed since `told` (RFC 7396).
std::string snapshot_text(const SensorSnapshot& snapshot);
std::string delta_text(const SensorSnapshot& sent, const SensorSnapshot& snapshot);

// Sensors as they are now, in memory: what a device said reaches those who watch it by way of here
// once it is durable. Only the newest counts; nothing is queued for anybody. Thread-safe.
class SensorHub {
public:
    // As it is now; older than what is known changes nothing. Wakes who watches it.
    void publish(const Sensor& sensor);
    // As the catalog has it, for who is about to watch it; where it is known already, nothing
    // changes.
    void introduce(const Sensor& sensor);
    // What the time alone changes of those that are known.
    void look_at_the_time();

    std::shared_ptr<const SensorSnapshot> find(const std::string& sensor) const;  // null: not known

    // Calls `on_change`, on any thread, whenever one of the sensors is another, until unwatch().
    std::uint64_t watch(const std::vector<std::string>& sensors, std::function<void()> on_change);
    void unwatch(std::uint64_t watcher);

    // The one stream of a sensor; `wake` is called when there is something for it to do, `end` when
    // another stream of the same sensor takes its place. On any thread.
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
