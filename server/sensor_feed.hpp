#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/sensors/sensor_hub.hpp"

namespace divemesh::server {

// What one client receives of the sensors that it watches: each sensor as a whole at first, then
// its changes, twice a second at most. Changes in between are skipped, not queued: the next delta
// leads from the last state sent to the newest.
class SensorFeed {
public:
    using Clock = std::chrono::steady_clock;

    SensorFeed(const api::SensorHub& sensor_hub, const std::vector<std::string>& sensors);

    // Returns a frame that is due; nullopt if none is due before next_at().
    std::optional<std::string> next(Clock::time_point now);
    // Returns when the first waiting frame is due; max() if none waits.
    Clock::time_point next_at() const;

private:
    struct WatchedSensor {
        std::string sensor;
        std::shared_ptr<const api::SensorSnapshot> snapshot;  // null: not sent yet
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
