#include "worker/report/report_page.hpp"

#include <algorithm>
#include <cstdio>

#include "worker/report/error_map.hpp"
#include "worker/report/figure_rows.hpp"
#include "worker/report/html_parts.hpp"
#include "worker/report/path_plots.hpp"
#include "worker/report/report_reef.hpp"

namespace divemesh::worker {
namespace {

using nlohmann::json;
using Grid = std::vector<std::vector<std::string>>;

std::string number_text(const json& value, const char* format = "%.6g", double factor = 1.0) {
    if (!value.is_number()) return "-";
    char text[64];
    std::snprintf(text, sizeof text, format, value.get<double>() * factor);
    return text;
}

std::string section(const std::string& title, const std::string& content) {
    return content.empty()
               ? ""
               : "<section><h2>" + escape_html(title) + "</h2>" + content + "</section>";
}

std::string name_of(const json& report) {
    const std::string name = report.at("dive").at("name");
    if (!name.empty()) return name;
    return "dive " + report.at("dive").at("content_sha256").get<std::string>().substr(0, 12);
}

std::string requirements(const json& report) {
    if (report.at("requirements").empty()) return "";
    std::string html =
        "<table><tr><th></th><th>Requirement</th><th>Figure</th><th>Value</th>"
        "<th>Reason</th></tr>";
    for (const json& requirement : report.at("requirements")) {
        const bool met = requirement.at("met");
        html += std::string("<tr><td class=\"") + (met ? "met\">met" : "unmet\">not met") +
                "</td><td>" + escape_html(requirement.at("text")) + "</td><td>" +
                escape_html(requirement.at("figure")) + "</td><td class=\"value\">" +
                number_text(requirement.at("value")) + "</td><td>" +
                escape_html(requirement.at("reason")) + "</td></tr>";
    }
    return html + "</table>";
}

std::string verdict(const json& report) {
    if (report.at("passed").is_null()) return "";
    const bool passed = report.at("passed");
    return std::string("<p class=\"") + (passed ? "met" : "unmet") + "\"><strong>" +
           (passed ? "All requirements are met." : "Not all requirements are met.") +
           "</strong></p>";
}

std::string regressions(const json& report) {
    if (report.at("regressions").empty()) return "";
    Grid grid = {{"Figure", "Value", "Allowed by its history", "Median of it", "Earlier values"}};
    for (const json& regression : report.at("regressions"))
        grid.push_back({regression.at("figure"),
                        number_text(regression.at("value")),
                        number_text(regression.at("limit")),
                        number_text(regression.at("median")),
                        number_text(regression.at("num_earlier"), "%.0f")});
    return html_grid(grid);
}

std::string interval_text(const json& figure) {
    const json interval = figure.value("interval95_m", json());
    if (!interval.is_array() || interval.size() != 2) return "";
    return number_text(interval[0], "%.4f") + " to " + number_text(interval[1], "%.4f");
}

std::string distances(const json& metrics) {
    const json list =
        metrics.value(json::json_pointer("/known_distances/distances"), json::array());
    if (list.empty()) return "";
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
    return "<div class=\"scroll\">" + html_grid(grid) + "</div>";
}

// Scale bars and printed sizes, then where each tag is.
std::string markers(const json& metrics) {
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
    return (bars.size() > 1 ? html_grid(bars) : "") +
           (tags.size() > 1 ? "<div class=\"scroll\">" + html_grid(tags) + "</div>" : "");
}

std::string error_map(const ReportMeasurements& measured) {
    if (measured.error_map_png.empty()) return "";
    std::string gradient;
    for (const std::string& color : error_map_colors())
        gradient += (gradient.empty() ? "" : ",") + color;
    return html_picture(measured.error_map_png, "Distance to the reference, from above") +
           "<p class=\"scale\"><span>0 mm</span><i style=\"background:linear-gradient(90deg," +
           gradient + ")\"></i><span>" + number_text(measured.error_map_end_m, "%.3g", 1e3) +
           " mm and more</span></p><p class=\"sub\">Distance of the surface seen from above to "
           "the reference; grey: farther than 4 m from every camera.</p>";
}

Plot histogram(const SurfaceError& surface) {
    PlotLine line{"share of the surface", "#0b6fa4", {}, {}, true};
    for (std::size_t i = 0; i < surface.histogram.size(); ++i)
        for (const std::size_t edge : {i, i + 1}) {
            line.x.push_back(static_cast<double>(edge) * kErrorBin_m * 1e3);
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
        rows.emplace_back("Orientations", "none: figures of rotation are left out");
    if (truth.contains("residual_rms_m"))
        rows.emplace_back("Residual of the solution, RMS",
                          number_text(truth["residual_rms_m"], "%.1f mm", 1e3));
    return rows;
}

std::string provenance(const json& report) {
    Grid grid = {{"What", "Name", "SHA-256"}};
    grid.push_back({"dive", name_of(report), report.at("dive").at("content_sha256")});
    grid.push_back({"calibration", "", report.at("reconstruction").at("calibration_sha256")});
    for (const json& file : report.at("files"))
        grid.push_back({file.at("role"), file.at("name"), file.at("sha256")});
    return "<p>Reconstructed by divemesh " +
           escape_html(report.at("reconstruction").at("version")) + ", preset " +
           escape_html(report.at("reconstruction").at("preset")) + "; reported by divemesh " +
           escape_html(report.at("version")) + ".</p><div class=\"scroll\">" + html_grid(grid) +
           "</div>";
}

std::string all_figures(const json& report) {
    Grid grid = {{"Figure", "Value", "Unit", "Method", "Alignment"}};
    for (const json& figure : report.at("figures"))
        grid.push_back({figure.at("figure"),
                        number_text(figure.at("value")),
                        figure.at("unit"),
                        figure.at("method"),
                        figure.at("alignment")});
    return "<details><summary>" + std::to_string(grid.size() - 1) +
           " figures with method and alignment</summary>" + html_grid(grid) + "</details>";
}

std::string plots(const ReportMeasurements& measured) {
    const TrajectoryError* error = measured.trajectory ? &*measured.trajectory : nullptr;
    std::string html = "<div class=\"row\">" + svg_plot(error_over_time(error, measured.path));
    if (error != nullptr && !error->segments.empty()) html += svg_plot(error_by_segment(*error));
    return html + "</div><div class=\"row\">" + svg_plot(path_from_above(error, measured.path)) +
           svg_plot(path_from_the_side(error, measured.path)) + "</div>";
}

}  // namespace

std::string report_page(const json& report, const ReportMeasurements& measured) {
    const json& metrics = measured.document;
    std::string html = html_head("Accuracy: " + name_of(report)) +
                       "<body><h1>Accuracy: " + escape_html(name_of(report)) + "</h1>" +
                       verdict(report);
    html += section("Requirements", requirements(report));
    html += section("Worse than their history allows", regressions(report));
    html += "<div class=\"row\">" + html_table("Against the truth", accuracy_rows(metrics)) +
            html_table("Expected, without truth", expected_rows(metrics)) +
            html_table("The truth", truth_rows(report)) + "</div>" + plots(measured);
    if (measured.surface)
        html += "<div class=\"row\">" + section("Surface error", error_map(measured)) +
                section("Histogram", svg_plot(histogram(*measured.surface))) + "</div>";
    html += section("Known distances", distances(metrics));
    html += section("Markers", markers(metrics));
    html += section("Reef and wreck figures", reef_table(measured.reef));
    html += "<div class=\"row\">" + html_table("The dive", dive_rows(metrics)) +
            html_table("The result", result_rows(metrics)) + "</div>";
    html += section("Findings", html_findings(report.at("findings")));
    html += section("Where it comes from", provenance(report));
    html += section("All figures", all_figures(report));
    return html + "</body></html>\n";
}

}  // namespace divemesh::worker
