#include "server/sensor_feed.hpp"

#include <algorithm>

namespace divemesh::server {
namespace {

// Two frames per sensor in this time: an image right after a status does not wait.
constexpr std::chrono::seconds kTwoFrames{1};

}  // namespace

SensorFeed::SensorFeed(const api::SensorHub& sensor_hub, const std::vector<std::string>& sensors)
    : sensor_hub_(sensor_hub) {
    for (const std::string& sensor : sensors) watched_.push_back({.sensor = sensor});
}

std::shared_ptr<const api::SensorSnapshot> SensorFeed::newer(const WatchedSensor& watched) const {
    auto newest = sensor_hub_.find(watched.sensor);
    return newest == watched.snapshot ? nullptr : std::move(newest);
}

SensorFeed::Clock::time_point SensorFeed::due_at(const WatchedSensor& watched) {
    const bool has_sent_two = watched.last_but_one != Clock::time_point::min();
    return has_sent_two ? watched.last_but_one + kTwoFrames : Clock::time_point::min();
}

std::string SensorFeed::frame_of(const WatchedSensor& watched, const api::SensorSnapshot& newest) {
    if (!watched.snapshot) return api::snapshot_text(newest);
    const bool is_next = newest.previous == watched.snapshot->revision && !newest.delta.empty();
    return is_next ? newest.delta : api::delta_text(*watched.snapshot, newest);
}

std::optional<std::string> SensorFeed::next(Clock::time_point now) {
    for (WatchedSensor& watched : watched_) {
        if (due_at(watched) > now) continue;
        auto newest = newer(watched);
        if (!newest) continue;
        std::string frame = frame_of(watched, *newest);
        watched.snapshot = std::move(newest);
        watched.last_but_one = std::exchange(watched.last, now);
        return frame;
    }
    return std::nullopt;
}

SensorFeed::Clock::time_point SensorFeed::next_at() const {
    auto first = Clock::time_point::max();
    for (const WatchedSensor& watched : watched_)
        if (newer(watched)) first = std::min(first, due_at(watched));
    return first;
}

}  // namespace divemesh::server
