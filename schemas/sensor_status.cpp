#include "schemas/sensor_status.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "schemas/enum_text.hpp"
#include "schemas/invalid_input.hpp"

namespace divemesh {
namespace {

using nlohmann::json;

constexpr EnumText<Summary> kSummaries[] = {
    {Summary::Ok, "ok"}, {Summary::Attention, "attention"}, {Summary::Stop, "stop"}};

constexpr std::size_t kMostErrors = 32;
constexpr std::size_t kMostErrorBytes = 256;
constexpr std::int64_t kLongestDive_s = 7 * 86'400;

// Below these a team looks, or ends the dive.
constexpr double kLowBattery = 0.2;
constexpr double kEmptyBattery = 0.1;
constexpr double kLowStorage_bytes = 4e9;  // some ten minutes of stereo pictures
constexpr double kFullStorage_bytes = 5e8;
constexpr double kDampHousing = 0.8;
// Shares of the pictures lately.
constexpr double kSomePictures = 0.1;
constexpr double kMostPictures = 0.5;

class Check {
public:
    Check(const json& status, const std::string& pointer) : status_(status), pointer_(pointer) {}

    void number(const StatusField& field) {
        const json* value = find(field.name);
        if (value == nullptr) return;
        if (field.is_flag) {
            if (!value->is_boolean()) fail(field.name, "has to be true or false");
            return;
        }
        number(*value, std::string(field.name), field.least, field.largest);
    }
    void text(const char* name, std::size_t most_bytes) {
        const json* value = find(name);
        if (value != nullptr &&
            (!value->is_string() || value->get_ref<const std::string&>().size() > most_bytes))
            fail(name, "has to be a text of " + std::to_string(most_bytes) + " bytes at most");
    }
    void errors() {
        const json* value = find("errors");
        if (value == nullptr) return;
        const auto is_short = [](const json& error) {
            return error.is_string() &&
                   error.get_ref<const std::string&>().size() <= kMostErrorBytes;
        };
        if (!value->is_array() || value->size() > kMostErrors ||
            !std::all_of(value->begin(), value->end(), is_short))
            fail("errors",
                 "has to be an array of " + std::to_string(kMostErrors) + " texts at most, of " +
                     std::to_string(kMostErrorBytes) + " bytes each");
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
            fail("orientation", "has to be a unit quaternion: an array of w, x, y, z");
    }
    void plan() {
        const json* value = find("dive_plan");
        if (value == nullptr) return;
        if (!value->is_object() || !value->contains("back_in_s"))
            return fail("dive_plan", "has to be an object with \"back_in_s\"");
        number((*value)["back_in_s"], "dive_plan/back_in_s", 0.0, kLongestDive_s);
    }
    void pictures() {
        const json* value = find("pictures");
        if (value == nullptr) return;
        if (!value->is_object()) return fail("pictures", "has to be an object");
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
    void number(const json& value, const std::string& place, double least, double largest) {
        if (!value.is_number()) return fail(place, "has to be a number");
        const auto number = value.get<double>();
        if (!(number >= least && number <= largest))
            fail(place, "has to be from " + json(least).dump() + " to " + json(largest).dump());
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

const json& pictures_of(const json& status) {
    static const json kNone = json::object();
    const auto found = status.find("pictures");
    return found == status.end() || !found->is_object() ? kNone : *found;
}

bool has_open_dive(const json& status) {
    const auto dive = status.find("dive");
    return dive != status.end() && dive->is_string() && *dive != "";
}

std::optional<Alarm> picture_alarm(const json& status) {
    std::optional<Alarm> alarm;
    double worst = kSomePictures;
    for (const char* name : {"dark", "blurred", "frozen"}) {
        const auto share = pictures_of(status).value(name, 0.0);
        if (share <= worst) continue;
        worst = share;
        alarm = Alarm{"pictures",
                      share > kMostPictures ? Summary::Stop : Summary::Attention,
                      percent(share) + " of the pictures are " + name +
                          ": look at a preview before the dive goes on"};
    }
    return alarm;
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
    check.pictures();
    check.finish();
}

std::vector<Alarm> alarms_of(const json& status) {
    const auto number = [&](std::string_view name) {
        return status_value(status, *find_status_field(name));
    };
    std::vector<Alarm> alarms;
    if (number("leak") == 1.0)
        alarms.push_back({"leak", Summary::Stop, "water in the housing: bring it up and open it"});
    else if (const auto humidity = number("humidity"); humidity && *humidity > kDampHousing)
        alarms.push_back(
            {"leak",
             Summary::Attention,
             "the air in the housing is damp (" + percent(*humidity) + "): check its seals"});
    if (const auto battery = number("battery"); battery && *battery < kLowBattery)
        alarms.push_back({"battery",
                          *battery < kEmptyBattery ? Summary::Stop : Summary::Attention,
                          "battery at " + percent(*battery) + ": charge or change it"});
    if (const auto free = number("storage_free_bytes"); free && *free < kLowStorage_bytes)
        alarms.push_back({"storage",
                          *free < kFullStorage_bytes ? Summary::Stop : Summary::Attention,
                          std::to_string(std::llround(*free / 1e6)) +
                              " MB are free for recordings: upload and remove older ones"});
    if (number("recording") == 0.0 && has_open_dive(status))
        alarms.push_back({"recording", Summary::Stop, "a dive is open and nothing is recorded"});
    if (auto alarm = picture_alarm(status)) alarms.push_back(std::move(*alarm));
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
