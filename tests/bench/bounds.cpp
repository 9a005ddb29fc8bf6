// How often what reconstructions state about their own accuracy comes true, over dives whose truth
// is known. Prints one JSON, and with --plot writes stated against observed as a picture.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <sstream>
#include <stdexcept>

#include "tests/bench/calibration_curve.hpp"
#include "tests/bench/kept_results.hpp"
#include "tests/bench/machine.hpp"
#include "tests/bench/program.hpp"
#include "tests/paths.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/dive/dive.hpp"
#include "worker/metrics/known_distances.hpp"
#include "worker/metrics/surface_index.hpp"
#include "worker/metrics/trajectory_error.hpp"
#include "worker/output/reconstruction_folder.hpp"
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
    fs::path folder;
    double baseline_error = 0.0;  // to be written into its calibration, relative
};

struct SimulatedDive {
    std::string scene;
    int seed = 0;
    int num_laps = 0;  // 0: an open path

    std::string name() const {
        return (num_laps > 0 ? "laps" : scene) + "-" + std::to_string(seed);
    }
};

// Small pictures of 3 m: a minute of processor time for dive and model, for two laps two.
fs::path rendered(const SimulatedDive& dive, const Options& options) {
    const fs::path folder = options.cache / ("bounds-" + dive.name());
    if (fs::exists(folder)) return folder;
    const fs::path unfinished = folder.string() + ".part";
    fs::create_directories(options.cache);
    fs::remove_all(unfinished);
    std::vector<std::string> words = {options.program.string(), "simulate", "--scene", dive.scene};
    for (const auto& [flag, value] : {std::pair<std::string, std::string>{"--length-m", "3"},
                                      {"--rate", "10"},
                                      {"--width-px", "400"},
                                      {"--height-px", "300"}})
        words.insert(words.end(), {flag, value});
    words.insert(words.end(), {"--seed", std::to_string(dive.seed), "--out", unfinished.string()});
    if (dive.scene != "tank") words.insert(words.end(), {"--water", "green"});
    if (dive.num_laps > 0) words.insert(words.end(), {"--laps", std::to_string(dive.num_laps)});
    const fs::path log = folder.string() + ".log";
    if (run_program(words, log) != 0) throw std::runtime_error("not rendered: " + last_lines(log));
    fs::rename(unfinished, folder);
    return folder;
}

// What bounds take a calibration's baseline and focal length to err by, drawn for a dive.
double baseline_error_of(const SimulatedDive& dive) {
    constexpr double kCalibrationSigma = 0.001;
    const std::string name = dive.scene + " " + dive.name();
    std::seed_seq seeds(name.begin(), name.end());
    std::mt19937_64 random(seeds);
    return kCalibrationSigma * std::normal_distribution<double>()(random);
}

json marks_of(const Eigen::Vector3d& p_world, const worker::MarkingInput& input) {
    json marks = json::array();
    for (const worker::Mark& mark : worker::mark_point(p_world, input)) {
        marks.push_back({{"timestamp_ns", mark.timestamp_ns},
                         {"left", {mark.pixel_left.x(), mark.pixel_left.y()}}});
        if (mark.pixel_right)
            marks.back()["right"] = {mark.pixel_right->x(), mark.pixel_right->y()};
    }
    return marks;
}

// The ends of the known distances, marked in every fifth frame as the true rig saw them.
json marked_distances(const worker::Dive& dive) {
    const auto reference = dive.read_reference_mesh();
    if (!reference) return json::array();
    std::vector<std::int64_t> timestamps_ns;
    for (std::size_t i = 0; i < dive.ground_truth().size(); i += 5)
        timestamps_ns.push_back(dive.ground_truth()[i].timestamp_ns);
    const worker::SurfaceIndex surface(*reference);
    const worker::MarkingInput input{dive.rig(), dive.ground_truth(), timestamps_ns, surface};
    json distances = json::array();
    for (const worker::KnownDistance& known : dive.known_distances())
        distances.push_back({{"name", known.name},
                             {"distance_m", known.distance_m},
                             {"marks_a", marks_of(known.a_world, input)},
                             {"marks_b", marks_of(known.b_world, input)}});
    return distances;
}

// cam1's place on the body, in the text of its sensor.yaml.
std::string with_place(const std::string& yaml, const Eigen::Vector3d& place) {
    const std::size_t begin = yaml.find('[', yaml.find("T_BS")) + 1;
    const std::size_t end = yaml.find(']', begin);
    std::istringstream items(yaml.substr(begin, end - begin));
    std::ostringstream list;
    list << std::setprecision(15);
    std::string item;
    for (int i = 0; std::getline(items, item, ','); ++i) {
        if (i > 0) list << ", ";
        if (i < 12 && i % 4 == 3)
            list << place[i / 4];
        else
            list << std::stod(item);
    }
    return yaml.substr(0, begin) + list.str() + yaml.substr(end);
}

// A copy, its pictures as links, whose calibration has a baseline longer by this share: as it is
// for whoever calibrated a rig.
fs::path with_baseline_error(const NamedDive& dive, const fs::path& folder) {
    const fs::path copy = folder / (dive.name + "-dive");
    fs::remove_all(copy);
    fs::copy(dive.folder, copy, fs::copy_options::recursive | fs::copy_options::create_hard_links);
    const TemporaryFolder scratch;
    const auto exact = worker::Dive::open(dive.folder, scratch.path());
    const Eigen::Vector3d left = exact->rig().T_imu_cam0.translation();
    const Eigen::Vector3d right = exact->rig().T_imu_cam1.translation();
    const fs::path yaml = copy / "mav0" / "cam1" / "sensor.yaml";
    std::stringstream text;
    text << std::ifstream(yaml).rdbuf();
    const std::string altered =
        with_place(text.str(), left + (1.0 + dive.baseline_error) * (right - left));
    const fs::path measurements = copy / "measurements.json";
    for (const fs::path& file : {yaml, measurements}) fs::remove(file);  // not the link's other end
    std::ofstream(yaml) << altered;
    std::ofstream(measurements) << json{{"distances", marked_distances(*exact)}}.dump();
    return copy;
}

// The level at which each of some vertices would just have been within its bound, and the share of
// them that is within what 95 % of the surface should be.
void add_surface(const fs::path& dive_folder, const fs::path& result_folder, json& result) {
    const TemporaryFolder scratch;
    const auto dive = worker::Dive::open(dive_folder, scratch.path());
    const auto reference = dive->read_reference_mesh();
    if (!reference || dive->ground_truth().empty()) return;
    const worker::ReconstructionFolder folder(result_folder);
    const worker::Mesh mesh = folder.mesh();
    const Eigen::Isometry3f T = worker::trajectory_error(folder.trajectory(), dive->ground_truth())
                                    .T_reference_surface.cast<float>();
    const worker::SurfaceIndex truth(*reference);
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

json measured(const NamedDive& dive, const Options& options, const fs::path& folder) {
    const fs::path altered =
        dive.baseline_error == 0.0 ? fs::path() : with_baseline_error(dive, folder);
    const fs::path out = folder / dive.name;
    const fs::path log = folder / (dive.name + ".log");
    const int code = run_program({options.program.string(),
                                  "reconstruct",
                                  (altered.empty() ? dive.folder : altered).string(),
                                  "--out",
                                  out.string(),
                                  "--no-texture"},
                                 log);
    if (code != 0) throw std::runtime_error(dive.name + ": " + last_lines(log));
    json result = {
        {"dive", dive.name}, {"baseline_error", dive.baseline_error}, {"samples", json::object()}};
    const json metrics = json::parse(std::ifstream(out / "metrics.json"));
    add_trajectory(metrics, result["samples"]);
    add_surface(dive.folder, out, result);
    result["expected_accuracy"] = metrics["expected_accuracy"];
    fs::remove_all(out);
    if (!altered.empty()) fs::remove_all(altered);
    return result;
}

std::vector<NamedDive> dives_of(const Options& options) {
    std::vector<NamedDive> dives;
    for (const char* shared : {"tank", "barge", "euroc_mh01"})
        if (options.shared && fs::exists(shared_data(shared)))
            dives.push_back({shared, shared_data(shared)});
    const char* scenes[] = {"tank", "barge", "reef"};
    for (const int seed : options.seeds) {
        std::vector<SimulatedDive> of_seed;
        for (const char* scene : scenes) of_seed.push_back({scene, seed});
        of_seed.push_back({scenes[seed % 3], seed, 2});
        for (const SimulatedDive& dive : of_seed)
            dives.push_back(
                {"sim-" + dive.name(), rendered(dive, options), baseline_error_of(dive)});
    }
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
    const char* colors[] = {"#0b6fa4", "#b3541e", "#2e7d4f", "#7b4ba0", "#a08a1e", "#a3231f"};
    worker::Plot plot{"Stated level against observed frequency (number of dives)",
                      "stated",
                      "observed",
                      {},
                      true};
    plot.lines.push_back({"honest", "#9aa7af", {0.0, 1.0}, {0.0, 1.0}});
    for (std::size_t i = 0; i < curves.size(); ++i) {
        if (curves[i].num_dives() == 0) continue;
        const std::string name =
            curves[i].kind() + " (" + std::to_string(curves[i].num_dives()) + ")";
        worker::PlotLine line{name, colors[i % std::size(colors)], {0.0}, {0.0}};
        for (const double level : shown_levels()) {
            line.x.push_back(level);
            line.y.push_back(curves[i].held(level));
        }
        plot.lines.push_back(std::move(line));
    }
    std::string svg = worker::svg_plot(plot);
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
    CLI::App app{"How often stated bounds hold, as one JSON."};
    app.add_option("--program", options.program, "the divemesh to run")->required();
    app.add_option("--cache", options.cache, "folder of the rendered dives")
        ->required()
        ->take_last();
    app.add_option(
        "--first-seed", first_seed, "of the simulated dives, three scenes and a loop each");
    app.add_option("--seeds", num_seeds, "how many")->check(CLI::Range(0, 1000));
    app.add_flag("!--no-shared", options.shared, "leave out the shared dives");
    app.add_option(
        "--keep",
        options.keep,
        "leave the results in this folder; dives whose result is there are not repeated");
    app.add_option("--plot", options.plot, "SVG of stated against observed");
    CLI11_PARSE(app, argc, argv);

    for (int i = 0; i < num_seeds; ++i) options.seeds.push_back(first_seed + i);
    const TemporaryFolder temporary;
    if (!options.keep.empty()) std::filesystem::create_directories(options.keep);
    std::cout << bench::run(options, options.keep.empty() ? temporary.path() : options.keep).dump(2)
              << "\n";
}
