#include <array>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <memory>
#include <set>

#include "cli/command.hpp"
#include "cli/exit_code.hpp"
#include "cli/findings_text.hpp"
#include "cli/text.hpp"
#include "schemas/json.hpp"
#include "worker/base/atomic_file.hpp"
#include "worker/reef/measure_reconstruction.hpp"
#include "worker/report/drawing_page.hpp"

namespace divemesh::cli {
namespace {

using nlohmann::json;

std::string number_text(double value) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), std::abs(value) >= 1000.0 ? "%.6g" : "%.4g", value);
    return text.data();
}

std::string area_line(const json& area) {
    std::string line = area["name"].get<std::string>() + " (" + area["kind"].get<std::string>();
    if (area.contains("label")) line += ", " + area["label"].get<std::string>();
    line += "): ";
    if (area.contains("planar_area_m2"))
        line += number_text(area["planar_area_m2"].get<double>()) + " m2, ";
    if (area.contains("length_m")) line += number_text(area["length_m"].get<double>()) + " m, ";
    line += number_text(100.0 * area["coverage"].get<double>()) + " % seen";
    for (const char* key : {"sigma_m", "detail_m"})
        if (area.contains(key))
            line += std::string(key == std::string("sigma_m") ? ", sigma " : ", detail ") +
                    number_text(1000.0 * area[key].get<double>()) + " mm";
    return line + "\n";
}

std::vector<std::string> metric_row(const json& metric) {
    std::string name = "  " + metric["figure"].get<std::string>();
    if (metric.contains("label")) name += " of " + metric["label"].get<std::string>();
    const std::string resolution =
        metric.contains("resolution_m")
            ? "at " + number_text(1000.0 * metric["resolution_m"].get<double>()) + " mm"
            : "";
    if (metric.contains("refused"))
        return {name, resolution, "refused: " + metric["refused"].get<std::string>()};
    const auto number = [&](const char* key) { return number_text(metric[key].get<double>()); };
    return {name,
            resolution,
            number("value") + " " + metric["unit"].get<std::string>(),
            "[" + number("low") + ", " + number("high") + "]"};
}

// Prints area by area, then what belongs to several of them.
std::string report_text(const json& result) {
    std::string text;
    std::set<std::string> shown;
    for (const json& area : result["areas"]) {
        const std::string name = area["name"];
        shown.insert(name);
        std::vector<std::vector<std::string>> rows;
        for (const json& metric : result["figures"])
            if (metric["area"] == name) rows.push_back(metric_row(metric));
        text += area_line(area) + table_text(rows);
    }
    std::vector<std::vector<std::string>> rows;
    for (const json& metric : result["figures"])
        if (!shown.contains(metric["area"].get<std::string>())) rows.push_back(metric_row(metric));
    if (!rows.empty()) text += "quadrats together:\n" + table_text(rows);
    return text;
}

// Returns the findings on the reconstruction that concern its measurements, and its verdict as the
// last line.
std::string judgement_text(const json& reconstruction) {
    std::string text;
    for (const json& finding : reconstruction["findings"])
        text += finding_text(finding.get<Finding>());
    if (!reconstruction.contains("verdict")) return text;
    return text + "verdict on the reconstruction: " +
           verdict_words(reconstruction["verdict"].get<std::string>(),
                         reconstruction["restrictions"]) +
           "\n";
}

struct Options {
    reef::MeasureRequest request;
    std::filesystem::path csv;
    std::filesystem::path draw;
    std::filesystem::path write_areas;
};

int write_drawing_page(const Options& options) {
    const io::ReconstructionFolder model(options.request.reconstruction);
    report::write_drawing_page(model, options.draw);
    std::cout << options.draw.string() << "\n";
    return kExitDone;
}

int write_areas(const Options& options) {
    const io::ReconstructionFolder model(options.request.reconstruction);
    const json areas =
        reef::import_areas(*options.request.areas, model, options.request.area_import);
    base::write_file(options.write_areas, areas.dump(2) + "\n");
    std::cout << options.write_areas.string() << "\n";
    return kExitDone;
}

int measure(const Options& options, const Context& context) {
    if (!options.write_areas.empty()) return write_areas(options);
    if (!options.draw.empty()) return write_drawing_page(options);
    const json result = reef::measure_reconstruction(options.request);
    if (!options.csv.empty()) reef::write_metrics_csv(result["figures"], options.csv);
    std::cout << (context.json ? result.dump(2) + "\n"
                               : report_text(result) + judgement_text(result["reconstruction"]));
    return kExitDone;
}

void add_areas(CLI::App& command, Options& options) {
    reef::AreaImport& how = options.request.area_import;
    auto* areas = command.add_option("--areas",
                                     options.request.areas,
                                     "quadrats, polygons and transects: areas.json, GeoJSON, a "
                                     "shapefile (.shp) or a TagLab project");
    command
        .add_option("--areas-crs",
                    how.crs,
                    "coordinates of that file, if it does not tell: world, EPSG:4326, or "
                    "EPSG:326zz or EPSG:327zz")
        ->needs(areas);
    command
        .add_option("--name-column", how.name_column, "column of the names; default: name or id")
        ->needs(areas);
    command
        .add_option("--label-column",
                    how.label_column,
                    "column of the labels; default: label, class, species or TL_Class")
        ->needs(areas);
    command.add_option("--map", how.map, "map of a TagLab project that has several")->needs(areas);
    command
        .add_flag("--fill-holes", how.fill_holes, "take the outer outline of areas that have holes")
        ->needs(areas);
    command
        .add_option("--write-areas",
                    options.write_areas,
                    "write the areas to this file as areas.json, and do not measure")
        ->needs(areas);
}

}  // namespace

void add_measure(CLI::App& app, Context& context) {
    auto* command = app.add_subcommand(
        "measure", "measure areas, rugosity and other metrics of a reconstruction, with intervals");
    auto options = std::make_shared<Options>();
    command
        ->add_option(
            "reconstruction", options->request.reconstruction, "folder of a reconstruction")
        ->required();
    add_areas(*command, *options);
    command->add_option("--ground-truth",
                        options->request.ground_truth,
                        "trajectory (TUM, EuRoC) in the frame of the areas");
    command->add_option("--csv", options->csv, "also write the metrics to this file");
    command
        ->add_option(
            "--draw", options->draw, "write an HTML page to draw areas on, and do not measure")
        ->excludes("--areas")
        ->excludes("--csv");
    command->add_option("--threads", options->request.num_threads, "0: all cores")
        ->check(CLI::Range(0, 1024));
    command->callback([options, &context] {
        context.command = [options, &context] { return measure(*options, context); };
    });
}

}  // namespace divemesh::cli
