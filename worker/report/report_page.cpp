#include "worker/report/report_page.hpp"

#include <algorithm>
#include <cstdio>

#include "schemas/base64.hpp"
#include "worker/report/error_map.hpp"
#include "worker/report/html_template.hpp"
#include "worker/report/html_templates.hpp"
#include "worker/report/metric_rows.hpp"
#include "worker/report/path_plots.hpp"
#include "worker/report/report_reef.hpp"

namespace divemesh::report {
namespace {

using nlohmann::json;
using Grid = std::vector<std::vector<std::string>>;

std::string number_text(const json& value, const char* format = "%.6g", double factor = 1.0) {
    if (!value.is_number()) return "-";
    char text[64];
    std::snprintf(text, sizeof text, format, value.get<double>() * factor);
    return text;
}

std::string name_of(const json& report) {
    std::string name = report.at("dive").at("name");
    if (!name.empty()) return name;
    return "dive " + report.at("dive").at("content_sha256").get<std::string>().substr(0, 12);
}

json requirements(const json& report) {
    json list = json::array();
    for (const json& requirement : report.at("requirements"))
        list.push_back({{"met", requirement.at("met")},
                        {"text", requirement.at("text")},
                        {"figure", requirement.at("figure")},
                        {"value", number_text(requirement.at("value"))},
                        {"reason", requirement.at("reason")}});
    return list;
}

json regressions(const json& report) {
    Grid grid = {{"Metric", "Value", "Allowed by its history", "Median of it", "Earlier values"}};
    for (const json& regression : report.at("regressions"))
        grid.push_back({regression.at("figure"),
                        number_text(regression.at("value")),
                        number_text(regression.at("limit")),
                        number_text(regression.at("median")),
                        number_text(regression.at("num_earlier"), "%.0f")});
    return grid_values(grid);
}

std::string interval_text(const json& metric) {
    const json interval = metric.value("interval95_m", json());
    if (!interval.is_array() || interval.size() != 2) return "";
    return number_text(interval[0], "%.4f") + " to " + number_text(interval[1], "%.4f");
}

json distances(const json& metrics) {
    const json list =
        metrics.value(json::json_pointer("/known_distances/distances"), json::array());
    Grid grid = {
        {"Length", "Known, m", "Measured, m", "95 %, m", "Error, mm", "Error, %", "Keyframes"}};
    for (const json& distance : list)
        grid.push_back({distance.value("name", ""),
                        number_text(distance.value("known_m", json()), "%.4f"),
                        number_text(distance.value("measured_m", json()), "%.4f"),
                        interval_text(distance),
                        number_text(distance.value("error_m", json()), "%+.1f", 1e3),
                        number_text(distance.value("error_percent", json()), "%+.2f"),
                        number_text(distance.value("num_keyframes_a", json()), "%.0f") + " / " +
                            number_text(distance.value("num_keyframes_b", json()), "%.0f")});
    return grid_values(grid);
}

// Returns scale bars and printed sizes, then the place of each tag.
json markers(const json& metrics) {
    const json section = metrics.value("markers", json::object());
    Grid bars = {{"Length between tags",
                  "Known, m",
                  "Measured, m",
                  "Error, mm",
                  "Error, %",
                  "Sigma, mm",
                  "Left out: error, mm"}};
    for (const json& bar : section.value("bars", json::array()))
        bars.push_back(
            {bar.value("name", ""),
             number_text(bar.value("known_m", json()), "%.4f"),
             number_text(bar.value("measured_m", json()), "%.4f"),
             number_text(bar.value("error_mm", json()), "%+.2f"),
             number_text(bar.value("error_percent", json()), "%+.3f"),
             number_text(bar.value("sigma_m", json()), "%.2f", 1e3),
             number_text(bar.value(json::json_pointer("/leave_one_out/error_mm"), json()),
                         "%+.2f")});
    Grid tags = {{"Tag", "x, m", "y, m", "z, m", "Sigma, mm", "Keyframes"}};
    for (const json& tag : section.value("markers", json::array())) {
        const json position = tag.value("position_m", json::array({json(), json(), json()}));
        tags.push_back({number_text(tag.value("id", json()), "%.0f"),
                        number_text(position.at(0), "%.4f"),
                        number_text(position.at(1), "%.4f"),
                        number_text(position.at(2), "%.4f"),
                        number_text(tag.value("sigma_m", json()), "%.2f", 1e3),
                        number_text(tag.value("num_keyframes", json()), "%.0f")});
    }
    if (bars.size() < 2 && tags.size() < 2) return nullptr;
    return {{"bars", grid_values(bars)}, {"tags", grid_values(tags)}};
}

json error_map(const ReportMeasurements& measured) {
    if (measured.error_map_png.empty()) return nullptr;
    std::string colors;
    for (const std::string& color : error_map_colors())
        colors += (colors.empty() ? "" : ",") + color;
    return {{"png", encode_base64(measured.error_map_png)},
            {"colors", colors},
            {"end_mm", number_text(measured.error_map_end_m, "%.3g", 1e3)}};
}

Plot histogram(const evaluation::SurfaceError& surface) {
    PlotLine line{"share of the surface", "#0b6fa4", {}, {}, true};
    for (std::size_t i = 0; i < surface.histogram.size(); ++i)
        for (const std::size_t edge : {i, i + 1}) {
            line.x.push_back(static_cast<double>(edge) * evaluation::kErrorBin_m * 1e3);
            line.y.push_back(surface.histogram[i] * 100.0);
        }
    return {"Distance to the reference (last bin: all beyond)", "distance, mm", "share, %", {line}};
}

HtmlRows truth_rows(const json& report) {
    const json truth = report.value("truth", json::object());
    if (truth.empty()) return {};
    const json& offset = truth.at("time_offset_s");
    const json& lever = truth.at("lever_arm_m");
    HtmlRows rows = {{"Source", truth.value("source", "") + ", " + truth.value("format", "")}};
    std::string offset_text = number_text(offset.at("value"), "%.6f s");
    if (offset.contains("sigma"))
        offset_text += number_text(offset["sigma"], " \u00b1 %.2g ms", 1e3);
    const bool one_clock = offset.value("how", "") == "none";
    rows.emplace_back("Clock offset", one_clock ? "none: the dive's clock" : offset_text);
    std::string lever_text;
    for (std::size_t i = 0; i < 3; ++i) {
        lever_text += (i == 0 ? "" : ", ") + number_text(lever.at("vector").at(i), "%.4f");
        if (lever.contains("sigma"))
            lever_text += number_text(lever["sigma"].at(i), " \u00b1 %.4f");
    }
    const bool one_body = lever.value("how", "") == "none";
    rows.emplace_back("Lever arm, m", one_body ? "none: the rig's body" : lever_text);
    if (truth.value("positions_only", false))
        rows.emplace_back("Orientations", "none: rotation metrics are left out");
    if (truth.contains("residual_rms_m"))
        rows.emplace_back("Residual of the solution, RMS",
                          number_text(truth["residual_rms_m"], "%.1f mm", 1e3));
    return rows;
}

json provenance(const json& report) {
    Grid grid = {{"What", "Name", "SHA-256"}};
    grid.push_back({"dive", name_of(report), report.at("dive").at("content_sha256")});
    grid.push_back({"calibration", "", report.at("reconstruction").at("calibration_sha256")});
    for (const json& file : report.at("files"))
        grid.push_back({file.at("role"), file.at("name"), file.at("sha256")});
    return {{"reconstructed_by", report.at("reconstruction").at("version")},
            {"preset", report.at("reconstruction").at("preset")},
            {"reported_by", report.at("version")},
            {"files", grid_values(grid)}};
}

json all_metrics(const json& report) {
    Grid grid = {{"Metric", "Value", "Unit", "Method", "Alignment"}};
    for (const json& metric : report.at("figures"))
        grid.push_back({metric.at("figure"),
                        number_text(metric.at("value")),
                        metric.at("unit"),
                        metric.at("method"),
                        metric.at("alignment")});
    return grid_values(grid);
}

json plots(const ReportMeasurements& measured) {
    const evaluation::TrajectoryError* error =
        measured.trajectory ? &*measured.trajectory : nullptr;
    const bool has_segments = error != nullptr && !error->segments.empty();
    return {{"error_over_time", svg_plot(error_over_time(error, measured.path))},
            {"error_by_segment", has_segments ? svg_plot(error_by_segment(*error)) : ""},
            {"path_from_above", svg_plot(path_from_above(error, measured.path))},
            {"path_from_the_side", svg_plot(path_from_the_side(error, measured.path))}};
}

json surface(const ReportMeasurements& measured) {
    if (!measured.surface) return nullptr;
    return {{"error_map", error_map(measured)},
            {"histogram", svg_plot(histogram(*measured.surface))}};
}

}  // namespace

std::string report_page(const json& report, const ReportMeasurements& measured) {
    const json& metrics = measured.document;
    const json& passed = report.at("passed");
    const json& reconstruction = report.at("reconstruction");
    json values = {
        {"title", "Accuracy: " + name_of(report)},
        {"verdict", verdict_values(reconstruction)},
        {"judged", !passed.is_null()},
        {"passed", passed},
        {"requirements", requirements(report)},
        {"regressions", regressions(report)},
        {"accuracy", rows_values(accuracy_rows(metrics))},
        {"expected", rows_values(expected_rows(metrics))},
        {"truth", rows_values(truth_rows(report))},
        {"surface", surface(measured)},
        {"distances", distances(metrics)},
        {"markers", markers(metrics)},
        {"reef", reef_table(measured.reef)},
        {"dive", rows_values(dive_rows(metrics))},
        {"result", rows_values(result_rows(metrics))},
        {"reconstruction", {{"findings", findings_values(reconstruction.at("findings"))}}},
        {"findings", findings_values(report.at("findings"))},
        {"provenance", provenance(report)},
        {"num_metrics", report.at("figures").size()},
        {"metrics", all_metrics(report)}};
    values.update(plots(measured));
    return fill_template(accuracy_page_html(), values);
}

}  // namespace divemesh::report
