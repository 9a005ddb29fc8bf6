// How often what reconstructions state about their own accuracy comes true, over dives whose truth
// is known. Prints one JSON, and with --plot writes stated against observed as a plot.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>

#include "tests/bench/calibration_curve.hpp"
#include "tests/bench/kept_results.hpp"
#include "tests/bench/machine.hpp"
#include "tests/bench/simulated_dives.hpp"
#include "tests/paths.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/dive/dive.hpp"
#include "worker/evaluation/surface_index.hpp"
#include "worker/evaluation/trajectory_error.hpp"
#include "worker/io/reconstruction_folder.hpp"
#include "worker/report/svg_plot.hpp"

namespace divemesh::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// Beyond this along its normal a vertex has no truth: the reference is what cam0 saw within 4 m.
constexpr float kNoTruth_m = 0.3F;
constexpr std::size_t kVerticesPerDive = 4000;

struct Options {
    std::vector<int> seeds;
    bool shared = true;
    fs::path program;
    fs::path cache;  // of rendered dives
    fs::path keep;   // of results; "": nowhere
    fs::path plot;   // "": none
};

struct NamedDive {
    std::string name;
    std::optional<SimulatedDive> simulated;  // none: of the shared data
    fs::path folder;                         // of that
};

// The level at which each of some vertices would just have been within its bound, and the share of
// them that is within what 95 % of the surface should be.
void add_surface(const fs::path& dive_folder, const fs::path& result_folder, json& result) {
    const TemporaryFolder scratch;
    const auto dive = dive::Dive::open(dive_folder, scratch.path());
    const auto reference = dive->read_reference_mesh();
    if (!reference || dive->ground_truth().empty()) return;
    const io::ReconstructionFolder folder(result_folder);
    const types::Mesh mesh = folder.mesh();
    const Eigen::Isometry3f T =
        evaluation::trajectory_error(folder.trajectory(), dive->ground_truth())
            .T_reference_surface.cast<float>();
    const evaluation::SurfaceIndex truth(*reference);
    const double error_95_m = folder.metrics()["expected_accuracy"]["surface"]["error_95_m"];
    const std::size_t step = 1 + mesh.vertices.size() / kVerticesPerDive;
    json levels = json::array();
    double num_within = 0.0;
    double num = 0.0;
    for (std::size_t i = 0; i < mesh.vertices.size(); i += step, ++num) {
        const Eigen::Vector3f p = T * mesh.vertices[i];
        const Eigen::Vector3f normal = T.linear() * mesh.normals[i];
        const float error_m = std::min(truth.first_hit_m(p, normal).value_or(kNoTruth_m),
                                       truth.first_hit_m(p, -normal).value_or(kNoTruth_m));
        if (error_m >= kNoTruth_m) continue;
        levels.push_back(level_of_normal(error_m, mesh.sigma_m[i]));
        num_within += error_m <= error_95_m ? 1.0 : 0.0;
    }
    if (levels.empty()) return;
    result["share_with_truth"] = static_cast<double>(levels.size()) / num;
    result["within_error_95"] = num_within / static_cast<double>(levels.size());
    result["samples"]["vertex sigma"] = std::move(levels);
}

void add_trajectory(const json& metrics, json& samples) {
    const json& expected = metrics["expected_accuracy"];
    const json& measured = metrics["trajectory"]["final"];
    const auto add = [&](const char* kind, const char* section, const char* error) {
        const json::json_pointer pointer(std::string("/trajectory/") + section);
        if (!expected.contains(pointer) || !measured.contains(error)) return;
        samples[kind] = level_of_length(
            measured[error], expected[pointer]["expected_m"], expected[pointer]["bound_m"]);
    };
    add("end position", "end_position", "end_drift_m");
    add("trajectory (ATE)", "ate", "ate_rmse_m");
    for (const auto& [check, kind] :
         {std::pair<std::string, std::string>{"accelerometer", "scale, accelerometer"},
          {"pressure", "scale, pressure"},
          {"known_distances", "scale, known distances"}}) {
        const json::json_pointer pointer("/scale/" + check);
        if (expected.contains(pointer))
            samples[kind] = level_of_normal(expected[pointer]["scale"].get<double>() - 1.0,
                                            expected[pointer]["sigma"]);
    }
}

// The half width of an interval of 95 % is 1.96 sigma.
void add_distances(const json& metrics, json& samples) {
    const json::json_pointer pointer("/known_distances/distances");
    if (!metrics.contains(pointer)) return;
    json levels = json::array();
    for (const json& distance : metrics[pointer]) {
        if (!distance.contains("interval95_m")) continue;
        const double error_m =
            distance["measured_m"].get<double>() - distance["known_m"].get<double>();
        const double half_m =
            distance["interval95_m"][1].get<double>() - distance["measured_m"].get<double>();
        levels.push_back(level_of_normal(error_m, half_m / 1.959964));
    }
    if (!levels.empty()) samples["known distance"] = std::move(levels);
}

// Its truth, and its reconstruction.
struct Reconstructed {
    fs::path dive;
    fs::path model;
};

Reconstructed reconstructed(const NamedDive& dive, const Options& options, const fs::path& folder) {
    const fs::path out = folder / dive.name;
    if (dive.simulated) {
        const SimulatedDives dives{options.program, options.cache};
        dives.reconstruct(*dive.simulated, out);
        return {dives.rendered(*dive.simulated), out};
    }
    reconstruct_surface(options.program, dive.folder, out);
    return {dive.folder, out};
}

json measured(const NamedDive& dive, const Options& options, const fs::path& folder) {
    const Reconstructed found = reconstructed(dive, options, folder);
    json result = {{"dive", dive.name},
                   {"baseline_error", dive.simulated ? dive.simulated->baseline_error() : 0.0},
                   {"samples", json::object()}};
    const json metrics = json::parse(std::ifstream(found.model / "metrics.json"));
    add_trajectory(metrics, result["samples"]);
    add_distances(metrics, result["samples"]);
    add_surface(found.dive, found.model, result);
    result["expected_accuracy"] = metrics["expected_accuracy"];
    if (options.keep.empty()) fs::remove_all(found.model);
    return result;
}

std::vector<NamedDive> dives_of(const Options& options) {
    std::vector<NamedDive> dives;
    for (const char* shared : {"tank", "barge", "euroc_mh01"})
        if (options.shared && fs::exists(shared_data(shared)))
            dives.push_back({shared, std::nullopt, shared_data(shared)});
    for (const int seed : options.seeds)
        for (const SimulatedDive& dive : dives_of_seed(seed))
            dives.push_back({"sim-" + dive.name(), dive, {}});
    return dives;
}

void add_samples(const json& result, std::vector<CalibrationCurve>& curves) {
    for (CalibrationCurve& curve : curves) {
        if (!result["samples"].contains(curve.kind())) continue;
        const json& sample = result["samples"][curve.kind()];
        if (sample.is_array())
            curve.add(sample.get<std::vector<double>>());
        else
            curve.add(sample.get<double>());
    }
}

void write_plot(const std::vector<CalibrationCurve>& curves, const fs::path& file) {
    const char* colors[] = {
        "#0b6fa4", "#b3541e", "#2e7d4f", "#7b4ba0", "#a08a1e", "#a3231f", "#4a5560"};
    report::Plot plot{"Stated level against observed frequency (number of dives)",
                      "stated",
                      "observed",
                      {},
                      true};
    plot.lines.push_back({"honest", "#9aa7af", {0.0, 1.0}, {0.0, 1.0}});
    for (std::size_t i = 0; i < curves.size(); ++i) {
        if (curves[i].num_dives() == 0) continue;
        const std::string name =
            curves[i].kind() + " (" + std::to_string(curves[i].num_dives()) + ")";
        report::PlotLine line{name, colors[i % std::size(colors)], {0.0}, {0.0}};
        for (const double level : shown_levels()) {
            line.x.push_back(level);
            line.y.push_back(curves[i].held(level));
        }
        plot.lines.push_back(std::move(line));
    }
    std::string svg = report::svg_plot(plot);
    svg.insert(svg.find('>') + 1,
               "<style>text{font:11px sans-serif;fill:#415059}.title{font-size:13px;"
               "font-weight:600}.grid{stroke:#e4eaee}</style><rect width=\"100%\" "
               "height=\"100%\" fill=\"#fff\"/>");
    svg.insert(4, " xmlns=\"http://www.w3.org/2000/svg\"");
    std::ofstream(file) << svg << "\n";
}

json run(const Options& options, const fs::path& folder) {
    std::vector<CalibrationCurve> curves;
    for (const char* kind : {"end position",
                             "trajectory (ATE)",
                             "scale, accelerometer",
                             "scale, pressure",
                             "scale, known distances",
                             "known distance",
                             "vertex sigma"})
        curves.emplace_back(kind);
    const KeptResults kept(folder, options.program);
    json report = {{"machine", describe_machine()}, {"dives", json::array()}};
    double within = 0.0, num = 0.0;
    for (const NamedDive& dive : dives_of(options)) {
        std::cerr << dive.name << std::endl;
        auto result = kept.find("bounds-" + dive.name);
        if (!result) {
            result = measured(dive, options, folder);
            kept.keep("bounds-" + dive.name, *result);
        }
        add_samples(*result, curves);
        if (result->contains("within_error_95")) {
            within += (*result)["within_error_95"].get<double>();
            ++num;
        }
        (*result)["samples"].erase("vertex sigma");
        report["dives"].push_back(*result);
    }
    for (const CalibrationCurve& curve : curves)
        if (curve.num_dives() > 0) report["curves"].push_back(curve.to_json());
    if (num > 0.0) report["within_error_95"] = {{"num_dives", num}, {"mean_share", within / num}};
    if (!options.plot.empty()) write_plot(curves, options.plot);
    return report;
}

}  // namespace
}  // namespace divemesh::bench

int main(int argc, char** argv) {
    using namespace divemesh;
    bench::Options options;
    int first_seed = 31, num_seeds = 5;
    CLI::App app{"Measures how often stated bounds hold and prints one JSON document."};
    app.add_option("--program", options.program, "path of the divemesh program")->required();
    app.add_option("--cache", options.cache, "folder for rendered dives")->required()->take_last();
    app.add_option("--first-seed",
                   first_seed,
                   "first seed of the simulated dives; each seed gives three scenes and a loop");
    app.add_option("--seeds", num_seeds, "number of seeds")->check(CLI::Range(0, 1000));
    app.add_flag("!--no-shared", options.shared, "leave out the shared dives");
    app.add_option(
        "--keep",
        options.keep,
        "leave results and reconstructions in this folder; dives whose result is there are not "
        "repeated");
    app.add_option("--plot", options.plot, "write an SVG of observed against stated coverage");
    CLI11_PARSE(app, argc, argv);

    for (int i = 0; i < num_seeds; ++i) options.seeds.push_back(first_seed + i);
    const TemporaryFolder temporary;
    if (!options.keep.empty()) std::filesystem::create_directories(options.keep);
    std::cout << bench::run(options, options.keep.empty() ? temporary.path() : options.keep).dump(2)
              << "\n";
}
