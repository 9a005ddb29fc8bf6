#include "cli/metrics_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

#include "cli/text.hpp"

namespace divemesh::cli {
namespace {

using Rows = std::vector<std::vector<std::string>>;

std::string number_text(const char* format, double value) {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), format, value);
    return text.data();
}

// Six decimals, as in papers and other evaluation tools: micrometres of an error in metres.
std::string value_text(const nlohmann::json& value) {
    if (value.is_string()) return value.get<std::string>();
    if (!value.is_number_float()) return value.dump();
    const double number = value.get<double>();
    return number_text(std::abs(number) < 1e9 ? "%.6f" : "%.6g", number);
}

bool is_vector(const nlohmann::json& value) {
    constexpr std::size_t kMaxComponents = 4;
    return !value.empty() && value.size() <= kMaxComponents &&
           std::all_of(value.begin(), value.end(), [](const nlohmann::json& component) {
               return component.is_number_float();
           });
}

std::string vector_text(const nlohmann::json& vector) {
    std::string text;
    for (const auto& component : vector) {
        if (!text.empty()) text += ", ";
        text += value_text(component);
    }
    return text;
}

// Returns what distinguishes the rows of a list: the stage, the segment's length, the threshold.
std::string take_label(nlohmann::json& item, std::size_t index) {
    for (const char* key : {"stage", "name", "length_m", "threshold_m"}) {
        const auto found = item.find(key);
        if (found == item.end()) continue;
        std::string label =
            found->is_number() ? number_text("%.6g", found->get<double>()) : value_text(*found);
        item.erase(found);
        return label;
    }
    return std::to_string(index);
}

std::string field_name(const std::string& parent, const std::string& key) {
    return parent.empty() ? key : parent + "." + key;
}

void add_rows(Rows& rows, const std::string& name, const nlohmann::json& value) {
    if (value.is_object()) {
        for (const auto& [key, item] : value.items()) add_rows(rows, field_name(name, key), item);
    } else if (value.is_array() && is_vector(value)) {
        rows.push_back({name, vector_text(value)});
    } else if (value.is_array()) {
        for (std::size_t i = 0; i < value.size(); ++i) {
            if (!value[i].is_object()) continue;
            nlohmann::json item = value[i];
            const std::string row_name = name + "[" + take_label(item, i) + "]";
            add_rows(rows, row_name, item);
        }
    } else if (!value.is_null()) {
        rows.push_back({name, value_text(value)});
    }
}

struct SummaryLine {
    const char* text;
    const char* pointer;
    double factor;  // from the file's unit to the one shown
    const char* format;
};

// clang-format off
constexpr SummaryLine kSummary[] = {
    {"frames",                          "/frames/num_frames",                    1,    "%.0f"},
    {"frames constrained by vision",    "/frames/coverage",                      100,  "%.1f %%"},
    {"path",                            "/trajectory/path_length_m",             1,    "%.2f m"},
    {"easting known to",                "/georeference/easting_sigma_m",         1,    "%.2f m"},
    {"northing known to",               "/georeference/northing_sigma_m",        1,    "%.2f m"},
    {"heading known to",                "/georeference/heading_sigma_deg",       1,    "%.2f degrees"},
    {"trajectory error, RMSE",          "/trajectory/final/ate_rmse_m",          1000, "%.1f mm"},
    {"trajectory error, max",           "/trajectory/final/ate_max_m",           1000, "%.1f mm"},
    {"  causal, RMSE",                  "/trajectory/causal/ate_rmse_m",         1000, "%.1f mm"},
    {"drift of the path",               "/trajectory/final/drift_percent",       1,    "%.2f %%"},
    {"known distances measured",        "/known_distances/num_measured",         1,    "%.0f"},
    {"scale error from them",           "/known_distances/scale_error",          100,  "%.2f %%"},
    {"mesh to reference, median",       "/surface/accuracy/median_m",            1000, "%.1f mm"},
    {"reference to mesh, median",       "/surface/completeness/median_m",        1000, "%.1f mm"},
    {"mesh",                            "/mesh/area_m2",                         1,    "%.2f m2"},
    {"  of keyframe images covered",    "/mesh/covered_share",                   100,  "%.0f %%"},
    {"  of measured surface",           "/mesh/covered_share_of_matched",        100,  "%.0f %%"},
    {"  holes",                         "/mesh/num_holes",                       1,    "%.0f"},
    {"  area of the holes",             "/mesh/hole_area_m2",                    1,    "%.3f m2"},
    {"  removed as small parts",        "/mesh/small_components_m2",             1,    "%.3f m2"},
    {"  removed by max_sigma_m",        "/mesh/cut_by_sigma_m2",                 1,    "%.3f m2"},
    {"triangles",                       "/mesh/num_triangles",                   1,    "%.0f"},
    {"  before simplification",         "/mesh/simplification/num_triangles_before", 1, "%.0f"},
    {"  simplification error, RMS",     "/mesh/simplification/rms_m",            1000, "%.1f mm"},
    {"  simplification error, max",     "/mesh/simplification/max_m",            1000, "%.1f mm"},
    {"points",                          "/mesh/num_cloud_points",                1,    "%.0f"},
    {"speed",                           "/speed/frames_per_s",                   1,    "%.1f frames/s"},
    {"peak memory",                     "/speed/peak_memory_bytes",              1e-6, "%.0f MB"},
};
// clang-format on

}  // namespace

std::string metrics_summary(const nlohmann::json& metrics) {
    Rows rows;
    for (const auto& line : kSummary) {
        const nlohmann::json::json_pointer pointer(line.pointer);
        if (!metrics.contains(pointer) || !metrics[pointer].is_number()) continue;
        std::array<char, 48> text{};
        std::snprintf(
            text.data(), text.size(), line.format, metrics[pointer].get<double>() * line.factor);
        rows.push_back({line.text, text.data()});
    }
    return table_text(rows);
}

std::string metrics_table(const nlohmann::json& metrics) {
    nlohmann::json shown = metrics;
    for (const char* key : {"options", "findings"}) shown.erase(key);
    Rows rows;
    add_rows(rows, "", shown);
    return table_text(rows);
}

}  // namespace divemesh::cli
