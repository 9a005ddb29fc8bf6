#include "schemas/sensor.hpp"

#include <algorithm>

#include "schemas/enum_text.hpp"

namespace divemesh {
namespace {

constexpr EnumText<SensorState> kStates[] = {{SensorState::Online, "online"},
                                             {SensorState::Idle, "idle"},
                                             {SensorState::Submerged, "submerged"},
                                             {SensorState::Overdue, "overdue"},
                                             {SensorState::Lost, "lost"}};
constexpr std::size_t kMaxReportedGaps = 32;

}  // namespace

std::string_view to_string(SensorState state) { return enum_to_text(kStates, state); }
SensorState sensor_state_from_string(std::string_view text) {
    return enum_from_text<SensorState>(kStates, text, "sensor state");
}

SensorState sensor_state(std::int64_t seen_at_ms, std::int64_t back_at_ms, std::int64_t now_ms) {
    if (now_ms - seen_at_ms <= kSensorSilence_ms) return SensorState::Online;
    if (back_at_ms == 0) return SensorState::Idle;
    if (now_ms <= back_at_ms) return SensorState::Submerged;
    return now_ms - back_at_ms <= kSensorLost_ms ? SensorState::Overdue : SensorState::Lost;
}

Sensor as_of(Sensor sensor, std::int64_t now_ms) {
    sensor.state = sensor_state(sensor.seen_at_ms, sensor.back_at_ms, now_ms);
    sensor.summary = summary_of(sensor.alarms);
    if (sensor.status_at_ms > 0) sensor.status_age_ms = now_ms - sensor.status_at_ms;
    sensor.stale = sensor.status_at_ms == 0 || sensor.status_age_ms > kSensorSilence_ms;
    return sensor;
}

nlohmann::json newest_word(const Sensor& sensor) {
    nlohmann::json word = sensor.status;
    std::int64_t reported_at_ms = word.contains("pictures") ? sensor.status_at_ms : 0;
    for (const auto& [camera, preview] : sensor.previews) {
        const auto images = preview.about.find("pictures");
        if (images == preview.about.end() || preview.time_ms < reported_at_ms) continue;
        word["pictures"] = *images;
        reported_at_ms = preview.time_ms;
    }
    return word;
}

std::vector<SequenceRange> first_gaps(const SequenceRanges& received) {
    auto gaps = received.gaps();
    gaps.resize(std::min(gaps.size(), kMaxReportedGaps));
    return gaps;
}

void to_json(nlohmann::json& json, const Preview& preview) {
    json = {{"id", preview.id},
            {"camera", preview.camera},
            {"time_ms", preview.time_ms},
            {"width", preview.width},
            {"height", preview.height},
            {"num_bytes", preview.num_bytes},
            {"sha256", preview.sha256},
            {"about", preview.about}};
}

void from_json(const nlohmann::json& json, Preview& preview) {
    json.at("id").get_to(preview.id);
    json.at("camera").get_to(preview.camera);
    json.at("time_ms").get_to(preview.time_ms);
    json.at("width").get_to(preview.width);
    json.at("height").get_to(preview.height);
    json.at("num_bytes").get_to(preview.num_bytes);
    json.at("sha256").get_to(preview.sha256);
    preview.about = json.at("about");
}

void to_json(nlohmann::json& json, const Sensor& sensor) {
    json = {{"id", sensor.id},
            {"project", sensor.project},
            {"state", to_string(sensor.state)},
            {"summary", to_string(sensor.summary)},
            {"alarms", sensor.alarms},
            {"boot_id", sensor.boot_id},
            {"hello", sensor.hello},
            {"status", sensor.status},
            {"status_at_ms", sensor.status_at_ms},
            {"status_age_ms", sensor.status_age_ms},
            {"stale", sensor.stale},
            {"previews", sensor.previews},
            {"seen_at_ms", sensor.seen_at_ms},
            {"back_at_ms", sensor.back_at_ms},
            {"acknowledged", sensor.received.acknowledged()},
            {"gaps", first_gaps(sensor.received)},
            {"num_lost", sensor.received.num_lost()},
            {"created_at_ms", sensor.created_at_ms}};
}

void to_json(nlohmann::json& json, const SensorHistory& history) {
    json = {{"from_ms", history.from_ms},
            {"to_ms", history.to_ms},
            {"step_ms", history.step_ms},
            {"time_ms", nlohmann::json::array()},
            {"num_statuses", nlohmann::json::array()},
            {"fields", nlohmann::json::object()}};
    for (const SensorHistory::Step& step : history.steps) {
        json["time_ms"].push_back(step.time_ms);
        json["num_statuses"].push_back(step.num_statuses);
    }
    const auto column = [&](std::size_t field, double SensorHistory::Value::*part) {
        auto values = nlohmann::json::array();
        for (const SensorHistory::Step& step : history.steps) {
            const auto& value = step.values[field];
            values.push_back(value ? nlohmann::json((*value).*part) : nlohmann::json());
        }
        return values;
    };
    for (std::size_t i = 0; i < history.fields.size(); ++i)
        json["fields"][history.fields[i]] = {{"least", column(i, &SensorHistory::Value::min)},
                                             {"mean", column(i, &SensorHistory::Value::mean)},
                                             {"largest", column(i, &SensorHistory::Value::max)}};
}

void to_json(nlohmann::json& json, const SensorAnswer& answer) {
    json = {{"boot_id", answer.boot_id},
            {"acknowledged", answer.acknowledged},
            {"gaps", answer.gaps},
            {"num_lost", answer.num_lost},
            {"num_new", answer.num_new},
            {"num_repeated", answer.num_repeated},
            {"superseded", answer.superseded},
            {"time_ms", answer.time_ms}};
}

}  // namespace divemesh
