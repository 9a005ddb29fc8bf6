#include "worker/compare/compare_report.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "schemas/base64.hpp"
#include "worker/base/text.hpp"
#include "worker/compare/change_images.hpp"
#include "worker/compare/comparison_page.hpp"
#include "worker/report/html_parts.hpp"
#include "worker/report/html_template.hpp"
#include "worker/report/svg_plot.hpp"
#include "worker/stats/distributions.hpp"

namespace divemesh::compare {
namespace {

using nlohmann::json;

double at(const json& document, const char* path) {
    return document.at(json::json_pointer(path)).get<double>();
}

// Returns a volume in litres or an area in cm2 with its bounds.
std::string bounds(const json& interval, double factor, int digits) {
    return base::fixed(factor * interval.at("value").get<double>(), digits) + " (" +
           base::fixed(factor * interval.at("low").get<double>(), digits) + " to " +
           base::fixed(factor * interval.at("high").get<double>(), digits) + ")";
}

std::string jpeg(const cv::Mat& image) {
    return encode_base64(encode_jpeg(image, kDisplaySide_px));
}

json totals(const json& document) {
    report::HtmlRows rows;
    for (const char* kind : {"grown", "lost"}) {
        const json& total = document.at(kind);
        const std::string name(kind);
        rows.emplace_back(name + ", patches", std::to_string(total.at("num_patches").get<int>()));
        rows.emplace_back(name + ", volume, litres (95 %)", bounds(total.at("volume_m3"), 1e3, 2));
        rows.emplace_back(name + ", undetected volume at most, litres",
                          base::fixed(1e3 * total.at("undetected_m3").get<double>(), 2));
        rows.emplace_back(name + ", area, cm² (95 %)", bounds(total.at("area_m2"), 1e4, 0));
    }
    rows.emplace_back("rest: rise less fall, litres (95 %)",
                      bounds(document.at("rest").at("volume_m3"), 1e3, 2));
    rows.emplace_back("rest: beyond its level of detection",
                      base::fixed(100.0 * at(document, "/rest/beyond_share"), 1) + " %");
    return report::rows_values(rows);
}

// Adds what a dive's own report says of it.
void add_dive(const std::string& name, const json& dive, report::HtmlRows& rows) {
    if (const json verdict = report::verdict_values(dive); !verdict.is_null())
        rows.emplace_back(name, verdict.at("text").get<std::string>());
    if (const int num_segments = dive.at("num_segments").get<int>(); num_segments > 1)
        rows.emplace_back(name + ", segments compared", "1 of " + std::to_string(num_segments));
    rows.emplace_back(name + ", scale, one standard deviation",
                      base::significant(100.0 * at(dive, "/scale_sigma"), 2) + " %");
}

json ground(const json& document) {
    report::HtmlRows rows;
    add_dive("earlier dive", document.at("a"), rows);
    add_dive("later dive", document.at("b"), rows);
    rows.emplace_back("seen by both", base::fixed(at(document, "/ground/both_m2"), 2) + " m²");
    rows.emplace_back("by the earlier dive alone",
                      base::fixed(at(document, "/ground/only_a_m2"), 2) + " m²");
    rows.emplace_back("by the later dive alone",
                      base::fixed(at(document, "/ground/only_b_m2"), 2) + " m²");
    rows.emplace_back("hidden from one of them",
                      base::fixed(at(document, "/ground/hidden_m2"), 2) + " m²");
    rows.emplace_back("level of detection, median",
                      base::fixed(1e3 * at(document, "/distances/median_lod95_m"), 1) + " mm");
    rows.emplace_back("M3C2 distance, median",
                      base::fixed(1e3 * at(document, "/distances/median_m"), 2) + " mm");
    rows.emplace_back("M3C2 distance, median size",
                      base::fixed(1e3 * at(document, "/distances/median_abs_m"), 2) + " mm");
    rows.emplace_back("cell, cylinder, normals over",
                      base::fixed(1e3 * at(document, "/options/cell_m"), 1) + ", " +
                          base::fixed(1e3 * at(document, "/options/cylinder_m"), 0) + ", " +
                          base::fixed(1e3 * at(document, "/options/normal_scale_m"), 0) + " mm");
    return report::rows_values(rows);
}

json registration(const json& document) {
    const json& fit = document.at("registration");
    report::HtmlRows rows;
    rows.emplace_back("found by", fit.at("method").get<std::string>());
    rows.emplace_back("of the later dive over ground of the earlier",
                      base::fixed(100.0 * at(fit, "/overlap"), 0) + " %");
    rows.emplace_back("of that within " + base::fixed(1e3 * at(fit, "/tolerance_m"), 0) + " mm",
                      base::fixed(100.0 * at(fit, "/agreement"), 0) + " %");
    rows.emplace_back("residual on stable surface, RMS",
                      base::fixed(1e3 * at(fit, "/residual_rms_m"), 2) + " mm");
    rows.emplace_back("uncertainty (95 %), x, y, z",
                      base::fixed(1e3 * at(fit, "/uncertainty95/x_m"), 2) + ", " +
                          base::fixed(1e3 * at(fit, "/uncertainty95/y_m"), 2) + ", " +
                          base::fixed(1e3 * at(fit, "/uncertainty95/z_m"), 2) + " mm");
    rows.emplace_back("uncertainty (95 %), tilt, heading",
                      base::fixed(at(fit, "/uncertainty95/tilt_deg"), 3) + "°, " +
                          base::fixed(at(fit, "/uncertainty95/heading_deg"), 3) + "°");
    if (fit.contains("scale_difference"))
        rows.emplace_back(
            "scale of the later dive, less that of the earlier (95 %)",
            base::fixed(100.0 * at(fit, "/scale_difference/value"), 2) + " ± " +
                base::fixed(100.0 * stats::kNormal975 * at(fit, "/scale_difference/sigma"), 2) +
                " %");
    rows.emplace_back("independent patches", std::to_string(fit.at("num_patches").get<int>()));
    return report::rows_values(rows);
}

json patches(const json& document) {
    json list = json::array();
    for (const json& patch : document.at("patches"))
        list.push_back({{"number", patch.at("number")},
                        {"kind", patch.at("kind")},
                        {"volume", bounds(patch.at("volume_m3"), 1e3, 2)},
                        {"area", bounds(patch.at("area_m2"), 1e4, 0)},
                        {"changes",
                         base::fixed(1e3 * at(patch, "/mean_change_m"), 0) + ", " +
                             base::fixed(1e3 * at(patch, "/largest_change_m"), 0) + " mm"},
                        {"center",
                         base::fixed(at(patch, "/center_m/0"), 2) + ", " +
                             base::fixed(at(patch, "/center_m/1"), 2) + " m"},
                        {"hidden", base::fixed(1e4 * at(patch, "/hidden_m2"), 0) + " cm²"}});
    if (list.empty()) return nullptr;
    return {{"list", list}};
}

// Returns a number with three significant digits; a rounding error of 0 is 0.
std::string significant(double value) {
    return base::significant(std::abs(value) < 1e-9 ? 0.0 : value, 3);
}

std::string estimate_text(const json& metric, const char* time, double factor) {
    const auto estimate = metric.find(time);
    if (estimate == metric.end()) return "";
    const auto text = [&](const char* bound) {
        return significant(factor * estimate->at(bound).get<double>());
    };
    return text("value") + " (" + text("low") + " to " + text("high") + ")";
}

std::string metric_name(const json& metric) {
    std::string name = metric.at("figure").get<std::string>();
    std::replace(name.begin(), name.end(), '_', ' ');
    const auto unit = metric.at("unit").get<std::string>();
    return unit.empty() ? name : name + ", " + (unit == "m3" ? "l" : unit);
}

double display_factor(const json& metric) { return metric.at("unit") == "m3" ? 1e3 : 1.0; }

json label_changes(const json& metrics) {
    std::vector<std::vector<std::string>> rows = {
        {"label", "metric", "earlier (95 %)", "later (95 %)", "change (95 %)"}};
    for (const json& metric : metrics) {
        if (metric.contains("area")) continue;
        const double factor = display_factor(metric);
        rows.push_back({metric.value("label", std::string()),
                        metric_name(metric),
                        estimate_text(metric, "earlier", factor),
                        estimate_text(metric, "later", factor),
                        metric.contains("refused")
                            ? "refused: " + metric.at("refused").get<std::string>()
                            : estimate_text(metric, "change", factor)});
    }
    return report::grid_values(rows);
}

// The metrics of each outline, by dive and name, then by metric.
using OutlineMetrics = std::map<std::pair<std::string, std::string>, std::map<std::string, json>>;

OutlineMetrics by_outline(const json& metrics) {
    OutlineMetrics found;
    for (const json& metric : metrics)
        if (metric.contains("area"))
            found[{metric.at("dive"), metric.at("area")}][metric.at("figure")] = metric;
    return found;
}

json outline_changes(const json& areas) {
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
    const OutlineMetrics metrics = by_outline(areas.at("figures"));
    for (const json& area : areas.at("areas")) {
        std::vector<std::string> row = {
            area.at("mark"),
            area.at("name"),
            area.at("dive"),
            area.value("label", std::string()),
            area.value("same_as", std::string()),
            base::fixed(1e4 * area.at("area_m2").get<double>(), 0),
            base::fixed(100.0 * area.at("coverage").get<double>(), 0) + " %"};
        const auto& of_outline = metrics.at({area.at("dive"), area.at("name")});
        for (const char* name : {"grown_volume", "lost_volume", "net_volume"}) {
            const json& metric = of_outline.at(name);
            row.push_back(metric.contains("refused") ? "refused"
                                                     : estimate_text(metric, "change", 1e3));
        }
        rows.push_back(std::move(row));
    }
    return report::grid_values(rows);
}

json areas(const json& document) {
    const auto found = document.find("areas");
    if (found == document.end()) return nullptr;
    return {{"labels", label_changes(found->at("figures"))},
            {"surveyed", base::fixed(found->at("surveyed_m2").get<double>(), 2) + " m²"},
            {"outlines", outline_changes(*found)}};
}

report::Plot noise_plot(const json& document) {
    report::PlotLine measured{"measured on stable ground", "#0b6fa4", {}, {}};
    report::PlotLine independent{"if cells erred independently", "#9aa7af", {}, {}};
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
    return report::fill_template(
        comparison_page_html(),
        {{"title", title_of(document.at("a")) + " → " + title_of(document.at("b"))},
         {"full_change", base::fixed(1e3 * input.full_change_m, 0) + " mm"},
         {"change", jpeg(input.difference)},
         {"earlier", jpeg(input.surface_a)},
         {"later", jpeg(input.surface_b)},
         {"totals", totals(document)},
         {"ground", ground(document)},
         {"patches", patches(document)},
         {"areas", areas(document)},
         {"registration", registration(document)},
         {"findings", report::findings_values(document.at("findings"))},
         {"noise", report::svg_plot(noise_plot(document))}});
}

}  // namespace divemesh::compare
