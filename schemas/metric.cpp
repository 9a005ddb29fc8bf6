#include "schemas/metric.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <set>

#include "schemas/embedded_schemas.hpp"
#include "schemas/error.hpp"
#include "schemas/known_metric.hpp"
#include "schemas/num_edits.hpp"

namespace divemesh {
namespace {

using nlohmann::json;

struct Description {
    std::string unit;
    std::string method;
};

// By name, with [*] for entries of lists. A name with the end ".*" stands for metrics of any name.
using Descriptions = std::map<std::string, Description>;

// clang-format off
constexpr std::pair<std::string_view, std::string_view> kUnits[] = {
    {"_deg_per_m", "deg/m"}, {"_m_s2", "m/s^2"}, {"_per_m2", "1/m^2"}, {"_per_m", "1/m"},
    {"_per_s", "1/s"},
    {"_m2", "m^2"}, {"_m3", "m^3"}, {"_px", "px"}, {"_deg", "deg"}, {"_percent", "%"}, {"_ppm", "ppm"},
    {"_bytes", "byte"}, {"_ns", "ns"}, {"_mm", "mm"}, {"_m", "m"}, {"_s", "s"}};

// The alignment that preceded a metric; the first match counts. `*` stands for final or causal.
constexpr std::pair<std::string_view, std::string_view> kAlignments[] = {
    {"trajectory.*.ate_", "SE(3) over positions (Umeyama 1991), scale 1"},
    {"trajectory.*.rotation_rmse", "SE(3) over positions (Umeyama 1991), scale 1"},
    {"trajectory.*.sim3_", "Sim(3) over positions (Umeyama 1991); diagnostic"},
    {"trajectory.*.end_drift", "first poses aligned with each other"},
    {"trajectory.*.", "none: relative"},
    {"trajectory.covariance.check", "first poses aligned with each other"},
    {"surface.", "SE(3) over positions and orientations of the path, scale 1; no ICP"},
    {"truth.", "SE(3) over positions, scale 1"}};
// clang-format on

// Returns true for numbers that are names or places, not metrics.
bool is_left_out(std::string_view key) {
    static constexpr std::string_view kKeys[] = {
        "format", "intervals", "from", "to", "id", "piece", "covered_images"};
    return std::find(std::begin(kKeys), std::end(kKeys), key) != std::end(kKeys);
}

// Returns the unit at the end of a name; for "time_offset_s.value" that of its parent.
std::string unit_of(std::string_view name) {
    while (!name.empty()) {
        const auto dot = name.rfind('.');
        std::string_view part = name.substr(dot == std::string_view::npos ? 0 : dot + 1);
        part = part.substr(0, part.find('['));
        if (part.starts_with("num_")) return "1";
        for (const auto& [ending, unit] : kUnits)
            if (part.ends_with(ending)) return std::string(unit);
        const bool is_part_of_parent = part == "value" || part == "sigma" || part == "vector" ||
                                       part == "angle" || part == "low" || part == "high";
        if (!is_part_of_parent || dot == std::string_view::npos) return "1";
        name = name.substr(0, dot);
    }
    return "1";
}

std::string alignment_of(const std::string& name) {
    for (const auto& [pattern, alignment] : kAlignments) {
        const auto star = pattern.find('*');
        if (star == std::string_view::npos) {
            if (name.starts_with(pattern)) return std::string(alignment);
            continue;
        }
        for (const std::string_view path : {"final", "causal"})
            if (name.starts_with(std::string(pattern.substr(0, star))
                                     .append(path)
                                     .append(pattern.substr(star + 1))))
                return std::string(alignment);
    }
    return "none";
}

std::string member_of(const std::string& name, std::string_view key) {
    std::string result = name;
    if (!name.empty()) result += '.';
    return result.append(key);
}

std::string entry_of(std::string name, std::string_view label) {
    return name.append("[").append(label).append("]");
}

bool is_number(const json& schema) {
    const auto type = schema.find("type");
    if (type == schema.end()) return false;
    const auto says = [](const json& word) { return word == "number" || word == "integer"; };
    return type->is_array() ? std::any_of(type->begin(), type->end(), says) : says(*type);
}

// Walks a schema down to its numbers.
class SchemaWalk {
public:
    SchemaWalk(const json& root, Descriptions& found) : root_(root), found_(found) {}

    void walk(const json& schema, const std::string& name, const std::string& parent_text) {
        const json& node = target_of(schema);
        const std::string text = schema.value("description", node.value("description", ""));
        if (is_number(node)) {
            std::string method = text;
            if (!parent_text.empty()) method += (method.empty() ? "" : "; ") + parent_text;
            found_[name] = {unit_of(name), method};
            return;
        }
        if (node.contains("items")) walk(node["items"], entry_of(name, "*"), text);
        const json properties = node.value("properties", json::object());
        for (const auto& [key, child] : properties.items())
            if (!is_left_out(key)) walk(child, member_of(name, key), name.empty() ? "" : text);
        if (node.value("additionalProperties", json(false)) == json(true) && name != "options")
            found_[name + ".*"] = {"", text};
    }

private:
    const json& target_of(const json& schema) const {
        const auto reference = schema.find("$ref");
        if (reference == schema.end()) return schema;
        return root_.at(json::json_pointer(reference->get<std::string>().substr(1)));
    }

    const json& root_;
    Descriptions& found_;
};

Descriptions read_descriptions() {
    Descriptions found;
    const json metrics = json::parse(metrics_schema_json());
    SchemaWalk(metrics, found).walk(metrics, "", "");
    const json report = json::parse(report_schema_json());
    SchemaWalk(report, found).walk(report.at("definitions").at("sections"), "", "");
    return found;
}

const Descriptions& descriptions() {
    static const Descriptions kKnown = read_descriptions();
    return kKnown;
}

// Returns whether `name` matches a pattern with [*].
bool fits(std::string_view pattern, std::string_view name) {
    const auto star = pattern.find("[*]");
    if (star == std::string_view::npos) return pattern == name;
    if (name.substr(0, star + 1) != pattern.substr(0, star + 1)) return false;
    const std::string_view rest = pattern.substr(star + 3);
    for (auto end = name.find(']', star + 2); end != std::string_view::npos;
         end = name.find(']', end + 1))
        if (fits(rest, name.substr(end + 1))) return true;
    return false;
}

// Returns the full name if `text` is the end of a name that `pattern` matches; otherwise nullopt.
std::optional<std::string> completed(const std::string& pattern, std::string_view text) {
    if (pattern.ends_with(".*")) {
        const auto open = std::string_view(pattern).substr(0, pattern.size() - 1);
        if (text.size() > open.size() && text.starts_with(open)) return std::string(text);
        return std::nullopt;
    }
    for (std::size_t start = 0; start != std::string::npos;) {
        if (pattern.find("[*]") >= start && fits(std::string_view(pattern).substr(start), text))
            return pattern.substr(0, start).append(text);
        const auto dot = pattern.find('.', start);
        start = dot == std::string::npos ? dot : dot + 1;
    }
    return std::nullopt;
}

// Returns the number of edits to the nearest end of the name; 0 if one contains the other.
std::size_t strangeness(std::string_view text, const std::string& name) {
    if (name.find(text) != std::string::npos) return 0;
    std::size_t best = num_edits(text, name);
    for (auto dot = name.find('.'); dot != std::string::npos; dot = name.find('.', dot + 1))
        best = std::min(best, num_edits(text, std::string_view(name).substr(dot + 1)));
    return best;
}

std::string list_text(const std::vector<std::string>& names) {
    constexpr std::size_t kMaxListed = 6;
    std::string text;
    for (std::size_t i = 0; i < std::min(names.size(), kMaxListed); ++i)
        text += (i == 0 ? "" : ", ") + names[i];
    return text + (names.size() > kMaxListed ? ", ..." : "");
}

std::string similar_names(std::string_view text) {
    std::vector<std::pair<std::size_t, std::string>> ranked;
    for (const std::string& name : known_metric_names())
        ranked.emplace_back(strangeness(text, name), name);
    std::stable_sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) {
        return a.first != b.first ? a.first < b.first : a.second.size() < b.second.size();
    });
    std::vector<std::string> names;
    for (std::size_t i = 0; i < std::min<std::size_t>(5, ranked.size()); ++i)
        names.push_back(ranked[i].second);
    return list_text(names);
}

std::ptrdiff_t depth_of(const std::string& name) {
    return std::count(name.begin(), name.end(), '.');
}

// Returns what distinguishes an entry of a list from the others.
std::string label_of(const json& entry, std::size_t index) {
    if (!entry.is_object()) return std::to_string(index);
    for (const char* key : {"name", "label", "stage", "id", "length_m", "threshold_m"}) {
        const auto found = entry.find(key);
        if (found == entry.end()) continue;
        if (found->is_string()) return found->get<std::string>();
        if (!found->is_number()) continue;
        std::array<char, 32> text{};
        std::snprintf(text.data(), text.size(), "%.6g", found->get<double>());
        return text.data();
    }
    return std::to_string(index);
}

// `described`: the same name with [*] in place of the entries' names.
void add_metrics(const json& value,
                 const std::string& name,
                 const std::string& described,
                 std::vector<Metric>& metrics) {
    if (value.is_object()) {
        for (const auto& [key, child] : value.items())
            if (!is_left_out(key))
                add_metrics(child, member_of(name, key), member_of(described, key), metrics);
    } else if (value.is_array()) {
        std::set<std::string> labels;
        for (std::size_t i = 0; i < value.size(); ++i) {
            std::string label = label_of(value[i], i);
            if (!labels.insert(label).second) label.append("#").append(std::to_string(i));
            add_metrics(value[i], entry_of(name, label), entry_of(described, "*"), metrics);
        }
    } else if (value.is_number() || value.is_null()) {
        const auto known = descriptions().find(described);
        const bool is_known = known != descriptions().end();
        metrics.push_back(
            {name,
             value.is_null() ? std::nullopt : std::optional<double>(value.get<double>()),
             is_known ? known->second.unit : unit_of(described),
             is_known ? known->second.method : "",
             alignment_of(name)});
    }
}

}  // namespace

std::vector<Metric> flatten_metrics(const json& document) {
    std::vector<Metric> metrics;
    json figured = document;
    for (const char* key : {"options", "findings"}) figured.erase(key);
    add_metrics(figured, "", "", metrics);
    return metrics;
}

std::vector<std::string> known_metric_names() {
    std::vector<std::string> names;
    for (const auto& [name, description] : descriptions()) names.push_back(name);
    return names;
}

std::vector<KnownMetric> known_metrics() {
    std::vector<KnownMetric> known;
    for (const auto& [name, description] : descriptions())
        known.push_back({name, description.unit, better_value(name), description.method});
    return known;
}

std::string resolve_metric(std::string_view text) {
    const std::string of_final_path = std::string("trajectory.final.").append(text);
    std::vector<std::string> found;
    for (const std::string& pattern : known_metric_names()) {
        const auto name = completed(pattern, text);
        if (!name) continue;
        if (*name == text || *name == of_final_path) return *name;
        found.push_back(*name);
    }
    if (found.empty())
        throw Error(ErrorCode::InvalidArgument,
                    std::string("there is no metric '")
                        .append(text.substr(0, 120))
                        .append("'; similar: " + similar_names(text)));
    std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
        return depth_of(a) < depth_of(b);
    });
    if (found.size() > 1 && depth_of(found[0]) == depth_of(found[1]))
        throw Error(
            ErrorCode::InvalidArgument,
            std::string("'").append(text).append("' is ambiguous, it could be " + list_text(found) +
                                                 ": write more of the name"));
    return found.front();
}

}  // namespace divemesh
