#include "server/sensor_feed.hpp"

#include <algorithm>

namespace divemesh::server {
namespace {

// Two frames in any so long: a picture right after a status does not wait.
constexpr std::chrono::seconds kTwoFrames{1};

}  // namespace

SensorFeed::SensorFeed(const api::SensorDesk& desk, const std::vector<std::string>& sensors)
    : desk_(desk) {
    for (const std::string& sensor : sensors) told_.push_back({.sensor = sensor});
}

std::shared_ptr<const api::SensorNews> SensorFeed::unheard(const Told& told) const {
    auto newest = desk_.find(told.sensor);
    return newest == told.news ? nullptr : std::move(newest);
}

SensorFeed::Clock::time_point SensorFeed::due_at(const Told& told) {
    const bool has_told_two = told.last_but_one != Clock::time_point::min();
    return has_told_two ? told.last_but_one + kTwoFrames : Clock::time_point::min();
}

std::string SensorFeed::frame_of(const Told& told, const api::SensorNews& newest) {
    if (!told.news) return api::snapshot_text(newest);
    const bool is_next = newest.previous == told.news->revision && !newest.delta.empty();
    return is_next ? newest.delta : api::delta_text(*told.news, newest);
}

std::optional<std::string> SensorFeed::next(Clock::time_point now) {
    for (Told& told : told_) {
        if (due_at(told) > now) continue;
        auto newest = unheard(told);
        if (!newest) continue;
        std::string frame = frame_of(told, *newest);
        told.news = std::move(newest);
        told.last_but_one = std::exchange(told.last, now);
        return frame;
    }
    return std::nullopt;
}

SensorFeed::Clock::time_point SensorFeed::next_at() const {
    auto first = Clock::time_point::max();
    for (const Told& told : told_)
        if (unheard(told)) first = std::min(first, due_at(told));
    return first;
}

}  // namespace divemesh::server
