#include "schemas/sensor_status.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "schemas/enum_text.hpp"
#include "schemas/invalid_input.hpp"

namespace divemesh {
namespace {

using nlohmann::json;

constexpr EnumText<Summary> kSummaries[] = {
    {Summary::Ok, "ok"}, {Summary::Attention, "attention"}, {Summary::Stop, "stop"}};

constexpr std::int64_t kMaxDive_s = std::int64_t{7} * 86'400;

// The limits from which a team should check the device, and should end the dive.
struct Limits {
    double attention = 0.0;
    double stop = 0.0;
    bool is_high = false;  // true: high values are bad; false: low ones
};
constexpr Limits kBattery{0.2, 0.1};
constexpr Limits kStorage_bytes{4e9, 5e8};  // about ten minutes and one minute of stereo images
constexpr Limits kHumidity{0.8, std::numeric_limits<double>::infinity(), true};
constexpr Limits kUselessImages{0.1, 0.5, true};  // as a share of the recent images
// Hysteresis: a raised alarm ends only this far beyond its limit, so a value that hovers there
// raises it once.
constexpr double kMargin = 0.1;

Summary level_of(double value, const Limits& limits, Summary before) {
    const auto is_beyond = [&](double limit, Summary level) {
        const double margin = before >= level ? kMargin : 0.0;
        return limits.is_high ? value > (1.0 - margin) * limit : value < (1.0 + margin) * limit;
    };
    if (is_beyond(limits.stop, Summary::Stop)) return Summary::Stop;
    return is_beyond(limits.attention, Summary::Attention) ? Summary::Attention : Summary::Ok;
}

Summary level_among(std::span<const Alarm> alarms, std::string_view name) {
    for (const Alarm& alarm : alarms)
        if (alarm.name == name) return alarm.level;
    return Summary::Ok;
}

class Check {
public:
    Check(const json& status, const std::string& pointer) : status_(status), pointer_(pointer) {}

    void number(const StatusField& field) {
        const json* value = find(field.name);
        if (value == nullptr) return;
        if (field.is_flag) {
            if (!value->is_boolean()) fail(field.name, "must be true or false");
            return;
        }
        number(*value, std::string(field.name), field.min, field.max);
    }
    void text(const char* name, std::size_t max_num_bytes) {
        const json* value = find(name);
        if (value != nullptr &&
            (!value->is_string() || value->get_ref<const std::string&>().size() > max_num_bytes))
            fail(name, "must be a text of at most " + std::to_string(max_num_bytes) + " bytes");
    }
    void errors() {
        const json* value = find("errors");
        if (value == nullptr) return;
        const auto is_short = [](const json& error) {
            return error.is_string() &&
                   error.get_ref<const std::string&>().size() <= kMaxStatusErrorBytes;
        };
        if (!value->is_array() || value->size() > kMaxStatusErrors ||
            !std::all_of(value->begin(), value->end(), is_short))
            fail("errors",
                 "must be an array of at most " + std::to_string(kMaxStatusErrors) +
                     " texts of at most " + std::to_string(kMaxStatusErrorBytes) + " bytes each");
    }
    void orientation() {
        const json* value = find("orientation");
        if (value == nullptr) return;
        double square = 0.0;
        bool is_numbers = value->is_array() && value->size() == 4;
        for (std::size_t i = 0; is_numbers && i < 4; ++i) {
            is_numbers = (*value)[i].is_number();
            square += is_numbers ? std::pow((*value)[i].get<double>(), 2) : 0.0;
        }
        if (!is_numbers || !(std::abs(square - 1.0) < 0.02))
            fail("orientation", "must be a unit quaternion: an array of w, x, y, z");
    }
    void plan() {
        const json* value = find("dive_plan");
        if (value == nullptr) return;
        if (!value->is_object() || !value->contains("back_in_s"))
            return fail("dive_plan", "must be an object with \"back_in_s\"");
        number((*value)["back_in_s"], "dive_plan/back_in_s", 0.0, kMaxDive_s);
    }
    void images() {
        const json* value = find("pictures");
        if (value == nullptr) return;
        if (!value->is_object()) return fail("pictures", "must be an object");
        for (const char* name : {"dark", "blurred", "frozen"})
            if (const auto share = value->find(name); share != value->end())
                number(*share, std::string("pictures/") + name, 0.0, 1.0);
    }
    void finish() {
        if (!faults_.empty()) throw InvalidInput(std::move(faults_));
    }

private:
    const json* find(std::string_view name) const {
        const auto value = status_.find(name);
        return value == status_.end() || value->is_null() ? nullptr : &*value;
    }
    void number(const json& value, const std::string& place, double min, double max) {
        if (!value.is_number()) return fail(place, "must be a number");
        const auto number = value.get<double>();
        if (!(number >= min && number <= max))
            fail(place, "must be from " + json(min).dump() + " to " + json(max).dump());
    }
    void fail(std::string_view place, const std::string& what) {
        std::string detail(1, '"');
        detail.append(place).append("\" ").append(what);
        faults_.push_back({std::move(detail), std::string(pointer_).append("/").append(place), ""});
    }

    const json& status_;
    const std::string& pointer_;
    std::vector<Fault> faults_;
};

std::string percent(double share) { return std::to_string(std::lround(100.0 * share)) + " %"; }

const json& images_of(const json& status) {
    static const json kNone = json::object();
    const auto found = status.find("pictures");
    return found == status.end() || !found->is_object() ? kNone : *found;
}

bool has_open_dive(const json& status) {
    const auto dive = status.find("dive");
    return dive != status.end() && dive->is_string() &&
           !dive->get_ref<const std::string&>().empty();
}

// Returns the most frequent kind of useless image, and its share.
std::pair<std::string, double> worst_images(const json& status) {
    std::pair<std::string, double> worst;
    for (const char* name : {"dark", "blurred", "frozen"}) {
        const auto share = images_of(status).value(name, 0.0);
        if (share > worst.second) worst = {name, share};
    }
    return worst;
}

}  // namespace

const StatusField* find_status_field(std::string_view name) {
    const auto* found = std::find_if(kStatusFields.begin(), kStatusFields.end(), [&](auto& field) {
        return field.name == name;
    });
    return found == kStatusFields.end() ? nullptr : found;
}

std::string_view to_string(Summary summary) { return enum_to_text(kSummaries, summary); }
Summary summary_from_string(std::string_view text) {
    return enum_from_text<Summary>(kSummaries, text, "summary");
}

std::optional<double> status_value(const json& status, const StatusField& field) {
    const auto value = status.find(field.name);
    if (value == status.end() || value->is_null()) return std::nullopt;
    return field.is_flag ? static_cast<double>(value->get<bool>()) : value->get<double>();
}

void check_status(const json& status, const std::string& pointer) {
    Check check(status, pointer);
    for (const StatusField& field : kStatusFields) check.number(field);
    check.text("dive", 64);
    check.text("clock_quality", 16);
    check.errors();
    check.orientation();
    check.plan();
    check.images();
    check.finish();
}

std::vector<Alarm> alarms_of(const json& status, std::span<const Alarm> before) {
    const auto number = [&](std::string_view name) {
        return status_value(status, *find_status_field(name));
    };
    std::vector<Alarm> alarms;
    const auto judge =
        [&](const char* name, double value, const Limits& limits, std::string detail) {
            const Summary level = level_of(value, limits, level_among(before, name));
            if (level != Summary::Ok) alarms.push_back({name, level, std::move(detail)});
        };
    if (number("leak") == 1.0)
        alarms.push_back(
            {"leak", Summary::Stop, "water in the housing: bring the device up and open it"});
    else if (const auto humidity = number("humidity"))
        judge("leak",
              *humidity,
              kHumidity,
              "the air in the housing is damp (" + percent(*humidity) + "): check the seals");
    if (const auto battery = number("battery"))
        judge("battery",
              *battery,
              kBattery,
              "battery at " + percent(*battery) + ": charge or replace it");
    if (const auto free = number("storage_free_bytes"))
        judge("storage",
              *free,
              kStorage_bytes,
              std::to_string(std::llround(*free / 1e6)) +
                  " MB are free for recordings: upload older recordings and remove them");
    if (number("recording") == 0.0 && has_open_dive(status))
        alarms.push_back({"recording",
                          Summary::Stop,
                          "a dive has started but nothing is recorded: start the recording"});
    const auto [kind, share] = worst_images(status);
    judge("pictures",
          share,
          kUselessImages,
          percent(share) + " of the images are " + kind +
              ": check a preview before the dive continues");
    return alarms;
}

Summary summary_of(std::span<const Alarm> alarms) {
    Summary summary = Summary::Ok;
    for (const Alarm& alarm : alarms) summary = std::max(summary, alarm.level);
    return summary;
}

void to_json(json& json, const Alarm& alarm) {
    json = {{"name", alarm.name}, {"level", to_string(alarm.level)}, {"detail", alarm.detail}};
}

void from_json(const json& json, Alarm& alarm) {
    json.at("name").get_to(alarm.name);
    alarm.level = summary_from_string(json.at("level").get<std::string>());
    json.at("detail").get_to(alarm.detail);
}

}  // namespace divemesh
