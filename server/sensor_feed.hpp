#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/sensors/sensor_hub.hpp"

namespace divemesh::server {

// What one client is told of the sensors that it watches: each as a whole at first, then what has
// changed, twice a second at most. What comes faster is left out, never queued: the next delta goes
// from what was told to what is newest.
class SensorFeed {
public:
    using Clock = std::chrono::steady_clock;

    SensorFeed(const api::SensorHub& sensor_hub, const std::vector<std::string>& sensors);

    // A frame that is due; nothing: none is before next_at().
    std::optional<std::string> next(Clock::time_point now);
    // When the first of those that wait for their time is due; max(): none waits.
    Clock::time_point next_at() const;

private:
    struct WatchedSensor {
        std::string sensor;
        std::shared_ptr<const api::SensorSnapshot> snapshot;  // null: nothing yet
        Clock::time_point last = Clock::time_point::min();
        Clock::time_point last_but_one = Clock::time_point::min();
    };

    static std::string frame_of(const WatchedSensor& watched, const api::SensorSnapshot& newest);
    static Clock::time_point due_at(const WatchedSensor& watched);
    std::shared_ptr<const api::SensorSnapshot> newer(const WatchedSensor& watched) const;

    const api::SensorHub& sensor_hub_;
    std::vector<WatchedSensor> watched_;
};

}  // namespace divemesh::server
