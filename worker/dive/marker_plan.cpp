#include "worker/dive/marker_plan.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <initializer_list>

#include "schemas/enum_text.hpp"
#include "schemas/invalid_input.hpp"

namespace divemesh::dive {
namespace {

using nlohmann::json;

constexpr EnumText<TagCorner> kCornerTexts[] = {{TagCorner::BottomLeft, "bottom_left"},
                                                {TagCorner::BottomRight, "bottom_right"},
                                                {TagCorner::TopRight, "top_right"},
                                                {TagCorner::TopLeft, "top_left"}};

constexpr double kMaxTagSize_m = 10.0;
constexpr double kMaxBarLength_m = 1000.0;
constexpr double kMaxSigma_m = 1.0;
constexpr std::size_t kMaxBars = 10'000;
constexpr std::size_t kMaxFaults = 20;
constexpr std::size_t kMaxNameLength = 200;

// A place in the document, as text for messages and as a JSON pointer.
struct Place {
    std::string name;
    std::string pointer;

    Place field(const std::string& key) const {
        const std::string shown = key.substr(0, kMaxNameLength);
        return {name.empty() ? shown : name + "." + shown, pointer + "/" + shown};
    }
    Place item(std::size_t i) const {
        return {name + "[" + std::to_string(i) + "]", pointer + "/" + std::to_string(i)};
    }
};

// Reads the document and collects all mistakes.
class PlanReader {
public:
    MarkerPlan read(const json& document) {
        if (!document.is_object())
            throw InvalidInput({{"markers.json is not a JSON object", "", ""}});
        allow(document, {}, {"family", "size_m", "size_sigma_m", "sizes_m", "scale_bars"});
        read_family(document);
        if (document.contains("size_m"))
            plan_.size_m = length(document, {}, "size_m", kMaxTagSize_m);
        if (document.contains("size_sigma_m"))
            plan_.size_sigma_m = sigma(document, {}, "size_sigma_m");
        read_sizes(document);
        read_bars(document);
        if (!faults_.empty()) throw InvalidInput(faults_);
        return std::move(plan_);
    }

private:
    void add(const Place& place, const std::string& rule) {
        if (faults_.size() < kMaxFaults)
            faults_.push_back({"field " + place.name + " " + rule, place.pointer, ""});
    }

    void allow(const json& object, const Place& at, std::initializer_list<const char*> known) {
        for (const auto& [key, value] : object.items())
            if (std::find(known.begin(), known.end(), key) == known.end())
                add(at.field(key), "is unknown");
    }

    static double number(const json& object, const std::string& key) {
        const auto found = object.find(key);
        const bool is_there = found != object.end() && found->is_number();
        return is_there ? found->get<double>() : std::nan("");
    }

    double length(const json& object, const Place& at, const std::string& key, double max_m) {
        const double value = number(object, key);
        if (!(value > 0.0 && value <= max_m))
            add(at.field(key),
                "must be a length in m, more than 0 and at most " +
                    std::to_string(static_cast<int>(max_m)));
        return value;
    }

    double sigma(const json& object, const Place& at, const std::string& key) {
        const double value = number(object, key);
        if (!(value >= 0.0 && value <= kMaxSigma_m))
            add(at.field(key), "must be a standard deviation in m, 0 to 1");
        return value;
    }

    void read_family(const json& document) {
        const auto found = document.find("family");
        if (found == document.end() || !found->is_string()) {
            add(Place().field("family"), "must name one of: tag36h11, tag25h9, tagStandard41h12");
            return;
        }
        try {
            plan_.family = marker_family_from_string(found->get<std::string>());
        } catch (const Error&) {
            add(Place().field("family"), "must be one of: tag36h11, tag25h9, tagStandard41h12");
        }
        num_ids_ = num_ids(plan_.family);
    }

    void read_sizes(const json& document) {
        const auto found = document.find("sizes_m");
        if (found == document.end()) return;
        if (!found->is_object()) {
            add(Place().field("sizes_m"),
                "must be an object with the sizes in m by id: {\"7\": 0.08}");
            return;
        }
        const Place at = Place().field("sizes_m");
        for (const auto& [key, value] : found->items()) {
            int id = -1;
            const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), id);
            if (error != std::errc() || end != key.data() + key.size() || !is_id(id))
                add(at.field(key),
                    "is not an id of the family: 0 to " + std::to_string(num_ids_ - 1));
            else
                plan_.sizes_m[id] = length(*found, at, key, kMaxTagSize_m);
        }
    }

    bool is_id(std::int64_t id) const { return id >= 0 && id < num_ids_; }

    void read_bars(const json& document) {
        const auto found = document.find("scale_bars");
        if (found == document.end()) return;
        if (!found->is_array() || found->size() > kMaxBars) {
            add(Place().field("scale_bars"),
                "must be a list of at most " + std::to_string(kMaxBars));
            return;
        }
        for (std::size_t i = 0; i < found->size() && faults_.size() < kMaxFaults; ++i)
            read_bar((*found)[i], Place().field("scale_bars").item(i));
    }

    void read_bar(const json& item, const Place& at) {
        if (!item.is_object()) {
            add(at, "must be an object");
            return;
        }
        allow(item, at, {"name", "from", "to", "distance_m", "sigma_m"});
        ScaleBar bar;
        bar.from = read_point(item, at, "from");
        bar.to = read_point(item, at, "to");
        bar.distance_m = length(item, at, "distance_m", kMaxBarLength_m);
        if (item.contains("sigma_m")) bar.sigma_m = sigma(item, at, "sigma_m");
        if (bar.from.id == bar.to.id && bar.from.corner == bar.to.corner)
            add(at.field("to"), "must be another point than \"from\"");
        bar.name = read_name(item, at, to_string(bar.from) + " - " + to_string(bar.to));
        plan_.scale_bars.push_back(bar);
    }

    std::string read_name(const json& item, const Place& at, const std::string& otherwise) {
        const auto found = item.find("name");
        if (found == item.end()) return otherwise;
        const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20; };
        if (found->is_string()) {
            auto name = found->get<std::string>();
            if (!name.empty() && name.size() <= kMaxNameLength &&
                std::none_of(name.begin(), name.end(), is_control))
                return name;
        }
        add(at.field("name"), "must be a text of 1 to 200 characters on one line");
        return otherwise;
    }

    // Reads 7, or {"id": 7, "corner": "top_left"}.
    MarkerPoint read_point(const json& item, const Place& at, const std::string& key) {
        const std::string rule = "must be an id (0 to " + std::to_string(num_ids_ - 1) +
                                 "), or {\"id\": .., \"corner\": one of bottom_left, bottom_right, "
                                 "top_right, top_left}";
        const auto found = item.find(key);
        if (found == item.end()) {
            add(at.field(key), rule);
            return {};
        }
        MarkerPoint point;
        const json* id = &*found;
        if (found->is_object()) {
            allow(*found, at.field(key), {"id", "corner"});
            id = found->contains("id") ? &found->at("id") : nullptr;
            if (found->contains("corner")) point.corner = corner(found->at("corner"));
            if (!point.corner) id = nullptr;
        }
        if (id == nullptr || !id->is_number_integer() || !is_id(id->get<std::int64_t>())) {
            add(at.field(key), rule);
            return {};
        }
        point.id = id->get<int>();
        return point;
    }

    static std::optional<TagCorner> corner(const json& value) {
        if (value.is_string())
            for (const auto& row : kCornerTexts)
                if (row.text == value.get<std::string>()) return row.value;
        return std::nullopt;
    }

    MarkerPlan plan_;
    int num_ids_ = 1;
    std::vector<Fault> faults_;
};

json to_json(const MarkerPoint& point) {
    if (!point.corner) return point.id;
    return {{"id", point.id}, {"corner", to_string(*point.corner)}};
}

}  // namespace

std::string_view to_string(TagCorner corner) { return enum_to_text(kCornerTexts, corner); }

std::string to_string(const MarkerPoint& point) {
    std::string text = std::to_string(point.id);
    if (point.corner) text.append(" ").append(to_string(*point.corner));
    return text;
}

std::optional<double> MarkerPlan::size_of(int id) const {
    const auto found = sizes_m.find(id);
    return found != sizes_m.end() ? std::optional(found->second) : size_m;
}

bool MarkerPlan::names(int id) const {
    return sizes_m.contains(id) ||
           std::any_of(scale_bars.begin(), scale_bars.end(), [id](const ScaleBar& bar) {
               return bar.from.id == id || bar.to.id == id;
           });
}

MarkerPlan marker_plan_from_json(const json& document) { return PlanReader().read(document); }

json to_json(const MarkerPlan& plan) {
    json document = {{"family", to_string(plan.family)}};
    if (plan.size_m) document["size_m"] = *plan.size_m;
    if (plan.size_sigma_m > 0.0) document["size_sigma_m"] = plan.size_sigma_m;
    for (const auto& [id, size_m] : plan.sizes_m) document["sizes_m"][std::to_string(id)] = size_m;
    for (const ScaleBar& bar : plan.scale_bars) {
        json entry = {{"name", bar.name},
                      {"from", to_json(bar.from)},
                      {"to", to_json(bar.to)},
                      {"distance_m", bar.distance_m}};
        if (bar.sigma_m > 0.0) entry["sigma_m"] = bar.sigma_m;
        document["scale_bars"].push_back(std::move(entry));
    }
    return document;
}

std::optional<MarkerPlan> marker_plan_of(const std::optional<MarkerPlan>& of_dive,
                                         const ReconstructionOptions& options) {
    if (options.marker_family.empty() && !of_dive) return std::nullopt;
    MarkerPlan plan = of_dive.value_or(MarkerPlan());
    if (!options.marker_family.empty())
        plan.family = marker_family_from_string(options.marker_family);
    if (options.marker_size_m > 0.0) {
        plan.size_m = options.marker_size_m;
        plan.sizes_m.clear();
    }
    return plan;
}

}  // namespace divemesh::dive
