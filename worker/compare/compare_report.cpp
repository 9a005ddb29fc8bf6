#include "worker/compare/compare_report.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "schemas/base64.hpp"
#include "worker/compare/change_pictures.hpp"
#include "worker/report/html_parts.hpp"
#include "worker/report/svg_plot.hpp"

namespace divemesh::worker {
namespace {

using nlohmann::json;

constexpr char kStyle[] = R"(
.grown{color:#2166ac}.lost{color:#b2182b}
.range{height:14px;border-radius:3px;background:linear-gradient(90deg,#b2182b,#f7f7f7,#2166ac)}
section img{min-width:70%}
.ends{display:flex;justify-content:space-between;font-size:13px;color:#415059})";

std::string number(double value, int digits) {
    char text[48];
    std::snprintf(text, sizeof text, "%.*f", digits, value);
    return text;
}

double at(const json& document, const char* path) {
    return document.at(json::json_pointer(path)).get<double>();
}

// A volume in litres or an area in cm2 with its bounds.
std::string bounds(const json& interval, double factor, int digits) {
    return number(factor * interval.at("value").get<double>(), digits) + " (" +
           number(factor * interval.at("low").get<double>(), digits) + " to " +
           number(factor * interval.at("high").get<double>(), digits) + ")";
}

std::string row(const std::string& name, const std::string& value) {
    return "<tr><td>" + escape_html(name) + "</td><td class=\"value\">" + escape_html(value) +
           "</td></tr>";
}

std::string picture(const std::string& title, const std::string& data) {
    return "<section><h2>" + escape_html(title) + "</h2><img alt=\"" + escape_html(title) +
           "\" src=\"data:image/" + data + "\"></section>";
}

std::string jpeg(const cv::Mat& image) {
    return "jpeg;base64," + encode_base64(encode_jpeg(image, kShownSide_px));
}

std::string totals(const json& document) {
    std::string html = "<section><h2>What changed</h2><table>";
    for (const char* kind : {"grown", "lost"}) {
        const json& total = document.at(kind);
        const std::string name(kind);
        html += row(name + ", patches", std::to_string(total.at("num_patches").get<int>()));
        html += row(name + ", volume, litres (95 %)", bounds(total.at("volume_m3"), 1e3, 2));
        html += row(name + ", of it undetected at most, litres",
                    number(1e3 * total.at("undetected_m3").get<double>(), 2));
        html += row(name + ", area, cm² (95 %)", bounds(total.at("area_m2"), 1e4, 0));
    }
    html += row("rest: rise less fall, litres (95 %)",
                bounds(document.at("rest").at("volume_m3"), 1e3, 2));
    html += row("rest: beyond its level of detection",
                number(100.0 * at(document, "/rest/beyond_share"), 1) + " %");
    return html + "</table></section>";
}

std::string ground(const json& document) {
    std::string html = "<section><h2>What was compared</h2><table>";
    html += row("seen by both", number(at(document, "/ground/both_m2"), 2) + " m²");
    html += row("by the earlier dive alone", number(at(document, "/ground/only_a_m2"), 2) + " m²");
    html += row("by the later dive alone", number(at(document, "/ground/only_b_m2"), 2) + " m²");
    html += row("hidden from one of them", number(at(document, "/ground/hidden_m2"), 2) + " m²");
    html += row("level of detection, median",
                number(1e3 * at(document, "/distances/median_lod95_m"), 1) + " mm");
    html +=
        row("M3C2 distance, median", number(1e3 * at(document, "/distances/median_m"), 2) + " mm");
    html += row("M3C2 distance, median size",
                number(1e3 * at(document, "/distances/median_abs_m"), 2) + " mm");
    html += row("cell, cylinder, normals over",
                number(1e3 * at(document, "/options/cell_m"), 1) + ", " +
                    number(1e3 * at(document, "/options/cylinder_m"), 0) + ", " +
                    number(1e3 * at(document, "/options/normal_scale_m"), 0) + " mm");
    return html + "</table></section>";
}

std::string registration(const json& document) {
    const json& fit = document.at("registration");
    std::string html = "<section><h2>How they were laid over each other</h2><table>";
    html += row("found by", fit.at("method").get<std::string>());
    html += row("of the later dive over ground of the earlier",
                number(100.0 * at(fit, "/overlap"), 0) + " %");
    html += row("of that within " + number(1e3 * at(fit, "/tolerance_m"), 0) + " mm",
                number(100.0 * at(fit, "/agreement"), 0) + " %");
    html +=
        row("residual on stable surface, RMS", number(1e3 * at(fit, "/residual_rms_m"), 2) + " mm");
    html += row("uncertainty (95 %), x, y, z",
                number(1e3 * at(fit, "/uncertainty95/x_m"), 2) + ", " +
                    number(1e3 * at(fit, "/uncertainty95/y_m"), 2) + ", " +
                    number(1e3 * at(fit, "/uncertainty95/z_m"), 2) + " mm");
    html += row("uncertainty (95 %), tilt, heading",
                number(at(fit, "/uncertainty95/tilt_deg"), 3) + "°, " +
                    number(at(fit, "/uncertainty95/heading_deg"), 3) + "°");
    html += row("patches that err independently", std::to_string(fit.at("num_patches").get<int>()));
    return html + "</table></section>";
}

std::string patches(const json& document) {
    if (document.at("patches").empty())
        return "<p>No patch of ground rose or sank beyond its level of detection.</p>";
    std::string html =
        "<table><tr><th>patch</th><th></th><th>volume, litres (95 %)</th><th>area, cm² "
        "(95 %)</th><th>mean, largest change</th><th>at x, y</th><th>hidden beside it</th></tr>";
    for (const json& patch : document.at("patches")) {
        const auto kind = patch.at("kind").get<std::string>();
        html += "<tr><td>" + std::to_string(patch.at("number").get<int>()) + "</td><td class=\"" +
                kind + "\">" + kind + "</td><td>" + bounds(patch.at("volume_m3"), 1e3, 2) +
                "</td><td>" + bounds(patch.at("area_m2"), 1e4, 0) + "</td><td>" +
                number(1e3 * at(patch, "/mean_change_m"), 0) + ", " +
                number(1e3 * at(patch, "/largest_change_m"), 0) + " mm</td><td>" +
                number(at(patch, "/center_m/0"), 2) + ", " + number(at(patch, "/center_m/1"), 2) +
                " m</td><td>" + number(1e4 * at(patch, "/hidden_m2"), 0) + " cm²</td></tr>";
    }
    return html + "</table>";
}

// Three or four figures are enough for a person.
std::string significant(double value) {
    char text[48];
    std::snprintf(text, sizeof text, "%.3g", std::abs(value) < 1e-9 ? 0.0 : value);
    return text;
}

std::string estimate_text(const json& figure, const char* time, double factor) {
    const auto estimate = figure.find(time);
    if (estimate == figure.end()) return "";
    const auto text = [&](const char* bound) {
        return significant(factor * estimate->at(bound).get<double>());
    };
    return text("value") + " (" + text("low") + " to " + text("high") + ")";
}

std::string figure_name(const json& figure) {
    std::string name = figure.at("figure").get<std::string>();
    std::replace(name.begin(), name.end(), '_', ' ');
    const auto unit = figure.at("unit").get<std::string>();
    return unit.empty() ? name : name + ", " + (unit == "m3" ? "l" : unit);
}

double shown_factor(const json& figure) { return figure.at("unit") == "m3" ? 1e3 : 1.0; }

std::string label_changes(const json& figures) {
    std::vector<std::vector<std::string>> rows = {
        {"label", "figure", "earlier (95 %)", "later (95 %)", "change (95 %)"}};
    for (const json& figure : figures) {
        if (figure.contains("area")) continue;
        const double factor = shown_factor(figure);
        rows.push_back({figure.value("label", std::string()),
                        figure_name(figure),
                        estimate_text(figure, "earlier", factor),
                        estimate_text(figure, "later", factor),
                        figure.contains("refused")
                            ? "refused: " + figure.at("refused").get<std::string>()
                            : estimate_text(figure, "change", factor)});
    }
    return rows.size() < 2 ? "" : "<h2>Labels</h2>" + html_grid(rows);
}

// Of each outline, by dive and name: its figures by theirs.
using OutlineFigures = std::map<std::pair<std::string, std::string>, std::map<std::string, json>>;

OutlineFigures by_outline(const json& figures) {
    OutlineFigures found;
    for (const json& figure : figures)
        if (figure.contains("area"))
            found[{figure.at("dive"), figure.at("area")}][figure.at("figure")] = figure;
    return found;
}

std::string outline_changes(const json& areas) {
    std::vector<std::vector<std::string>> rows = {{"",
                                                   "outline",
                                                   "of the dive",
                                                   "label",
                                                   "same as",
                                                   "area, cm²",
                                                   "seen by both",
                                                   "grown, l (95 %)",
                                                   "lost, l (95 %)",
                                                   "net, l (95 %)"}};
    const OutlineFigures figures = by_outline(areas.at("figures"));
    for (const json& area : areas.at("areas")) {
        std::vector<std::string> row = {
            area.at("mark"),
            area.at("name"),
            area.at("dive"),
            area.value("label", std::string()),
            area.value("same_as", std::string()),
            number(1e4 * area.at("area_m2").get<double>(), 0),
            number(100.0 * area.at("coverage").get<double>(), 0) + " %"};
        const auto& of_outline = figures.at({area.at("dive"), area.at("name")});
        for (const char* name : {"grown_volume", "lost_volume", "net_volume"}) {
            const json& figure = of_outline.at(name);
            row.push_back(figure.contains("refused") ? "refused"
                                                     : estimate_text(figure, "change", 1e3));
        }
        rows.push_back(std::move(row));
    }
    return rows.size() < 2 ? "" : "<h2>Outlines</h2>" + html_grid(rows);
}

std::string outline_colors(const json& document) {
    if (!document.contains("areas")) return "";
    return " Green: outlines of the earlier dive; violet: of the later.";
}

std::string areas(const json& document) {
    const auto found = document.find("areas");
    if (found == document.end()) return "";
    return label_changes(found->at("figures")) + "<p class=\"sub\">Labels over " +
           number(found->at("surveyed_m2").get<double>(), 2) +
           " m² that both dives saw. What is said of one year alone takes it for a sample of the "
           "reef; a change compares the same ground twice.</p>" +
           outline_changes(*found);
}

Plot noise_plot(const json& document) {
    PlotLine measured{"measured on stable ground", "#0b6fa4", {}, {}};
    PlotLine independent{"if cells erred independently", "#9aa7af", {}, {}};
    for (const json& step : document.at("noise")) {
        const double side_m = step.at("side_m").get<double>();
        measured.x.push_back(side_m);
        measured.y.push_back(step.at("sigma").get<double>());
        independent.x.push_back(side_m);
        independent.y.push_back(measured.y.front() * measured.x.front() / side_m);
    }
    return {"Error of a mean change",
            "side of the area, m",
            "in units of a cell's sigma",
            {measured, independent}};
}

std::string title_of(const json& dive) {
    const auto name = dive.at("name").get<std::string>();
    return name.empty() ? "dive " + dive.at("content_sha256").get<std::string>().substr(0, 12)
                        : name;
}

}  // namespace

std::string compare_report(const CompareReportInput& input) {
    const json& document = input.document;
    const std::string title = title_of(document.at("a")) + " → " + title_of(document.at("b"));
    const std::string full = number(1e3 * input.full_change_m, 0) + " mm";
    return html_head(title, kStyle) + "<body><h1>" + escape_html(title) +
           "</h1><p class=\"sub\">What changed between two dives of one place. Blue rose, red "
           "sank; "
           "only where both dives saw the ground, and only beyond the level of detection. Volumes "
           "are those between the two surfaces as seen from above.</p>" +
           picture("Change", jpeg(input.difference)) +
           "<div class=\"range\"></div><div class=\"ends\"><span>" + full +
           " lost</span><span>0</span><span>" + full +
           " grown</span></div><p class=\"sub\">Grey: the later dive, no change. Pale: seen by one "
           "dive alone. Orange lines: one dive did not look where the other has its "
           "surface." +
           outline_colors(document) + "</p><div class=\"row\">" + totals(document) +
           ground(document) + "</div><h2>Patches</h2>" + patches(document) + areas(document) +
           "<div class=\"row\">" + picture("Earlier dive", jpeg(input.surface_a)) +
           picture("Later dive", jpeg(input.surface_b)) + "</div><div class=\"row\">" +
           registration(document) + svg_plot(noise_plot(document)) + "</div></body></html>\n";
}

}  // namespace divemesh::worker
