// How often the intervals of reef metrics hold the truth, over squares of simulated dives. Prints
// one JSON.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <stdexcept>

#include "tests/bench/machine.hpp"
#include "tests/bench/program.hpp"
#include "tests/bench/simulated_dives.hpp"
#include "tests/bench/square_truth.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/evaluation/trajectory_error.hpp"
#include "worker/io/ply.hpp"
#include "worker/io/reconstruction_folder.hpp"
#include "worker/io/trajectory_file.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double kSide_m = 0.6;
constexpr double kMinKnownShare = 0.97;  // of a square, by reference.ply
constexpr double kMinSeenShare = 0.7;    // by the reconstruction

struct Options {
    std::vector<int> seeds;
    std::vector<std::string> scenes;
    fs::path program;
    fs::path cache;  // of rendered dives
    fs::path keep;   // of reconstructions
    bool each = false;
};

const char* const kTruthFile = "mav0/state_groundtruth_estimate0/data.csv";

// One metric of one square.
struct Sample {
    std::string square;
    double measured = 0.0;
    double low = 0.0;
    double high = 0.0;
    double truth = 0.0;

    double error() const { return measured - truth; }
    bool is_held() const { return low <= truth && truth <= high; }
    // Returns the error in standard deviations of the stated interval.
    double deviations() const { return error() / ((high - low) / (2.0 * 1.959964)); }
};

using DiveSamples = std::map<std::string, std::vector<Sample>>;  // by metric

struct KnownSquare {
    std::string name;
    Square square;
    SquareHeights truth;  // of what was not seen as well
    double share_seen = 0.0;
    double plane_z_m = 0.0;  // the lowest true height
};

double top_m(const types::Mesh& mesh) {
    float top = -1e9F;
    for (const Eigen::Vector3f& vertex : mesh.vertices) top = std::max(top, vertex.z());
    return top + 1.0;
}

types::Mesh in_truth_frame(types::Mesh mesh, const fs::path& model, const fs::path& dive) {
    const Eigen::Isometry3f T =
        evaluation::trajectory_error(io::ReconstructionFolder(model).trajectory(),
                                     io::read_trajectory(dive / kTruthFile).poses)
            .T_reference_surface.cast<float>();
    for (Eigen::Vector3f& vertex : mesh.vertices) vertex = T * vertex;
    return mesh;
}

// Side by side over all of the reference, those of which the truth is known and most was seen.
std::vector<KnownSquare> known_squares(const types::Mesh& reference, const types::Mesh& model) {
    const evaluation::SurfaceIndex truth(reference);
    const evaluation::SurfaceIndex seen(model);
    Eigen::AlignedBox2d box;
    for (const Eigen::Vector3f& vertex : reference.vertices)
        box.extend(vertex.head<2>().cast<double>());
    const double above_m = std::max(top_m(reference), top_m(model));
    std::vector<KnownSquare> squares;
    for (double y = box.min().y(); y + kSide_m <= box.max().y(); y += kSide_m)
        for (double x = box.min().x(); x + kSide_m <= box.max().x(); x += kSide_m) {
            KnownSquare square{"square " + std::to_string(squares.size()), {{x, y}, kSide_m}, {}};
            square.truth = heights_of(square.square, truth, above_m);
            if (square.truth.share_known() < kMinKnownShare) continue;
            const SquareHeights measured = heights_of(square.square, seen, above_m);
            square.share_seen = measured.share_known();
            if (square.share_seen < kMinSeenShare) continue;
            square.plane_z_m = true_range(square.truth)->low_m;
            squares.push_back(std::move(square));
        }
    return squares;
}

json areas_of(const std::vector<KnownSquare>& squares) {
    json areas = json::array();
    for (const KnownSquare& square : squares) {
        const double x = square.square.corner_m.x(), y = square.square.corner_m.y();
        const double z = square.plane_z_m, side = square.square.side_m;
        areas.push_back(
            {{"name", square.name},
             {"kind", "quadrat"},
             {"normal", {0, 0, 1}},
             {"corners",
              {{x, y, z}, {x + side, y, z}, {x + side, y + side, z}, {x, y + side, z}}}});
    }
    return {{"frame", "ground_truth"}, {"areas", areas}};
}

json measured(const std::vector<KnownSquare>& squares,
              const fs::path& model,
              const fs::path& dive,
              const Options& options) {
    const TemporaryFolder scratch;
    std::ofstream(scratch / "areas.json") << areas_of(squares).dump();
    const fs::path answer = scratch / "metrics.json";
    if (run_program({options.program.string(),
                     "--json",
                     "measure",
                     model.string(),
                     "--areas",
                     (scratch / "areas.json").string(),
                     "--ground-truth",
                     (dive / kTruthFile).string()},
                    answer,
                    true) != 0)
        throw std::runtime_error("not measured: " + model.string());
    return json::parse(std::ifstream(answer));
}

// What a dive tells of its true surface.
struct TrueSurface {
    types::Mesh mesh;
    std::vector<Eigen::Vector3d> cameras;  // some of them; the body's place is near enough
};

TrueSurface true_surface(const fs::path& dive) {
    constexpr std::size_t kMaxCameras = 60;
    TrueSurface surface{io::read_ply(dive / "reference.ply"), {}};
    const types::Trajectory path = io::read_trajectory(dive / kTruthFile).poses;
    const std::size_t step = 1 + path.size() / kMaxCameras;
    for (std::size_t i = 0; i < path.size(); i += step)
        surface.cameras.push_back(path[i].T_world_imu.translation());
    return surface;
}

std::optional<double> truth_of(const std::string& metric,
                               const json& entry,
                               const KnownSquare& square,
                               const TrueSurface& surface,
                               const evaluation::SurfaceIndex& index) {
    if (metric == "rugosity") return true_rugosity(square.truth, entry["resolution_m"]);
    if (metric == "height_range") return true_range(square.truth)->size_m();
    if (metric == "volume") return true_volume_m3(square.truth, square.plane_z_m);
    if (metric == "slope") return true_slope_deg(square.truth);
    if (metric == "planar_area") return square.square.side_m * square.square.side_m;
    if (metric == "surface_area" && square.share_seen >= kMinKnownShare)
        return true_surface_area_m2(square.square, surface.mesh, index, surface.cameras);
    return std::nullopt;
}

std::string label_of(const json& entry) {
    const std::string metric = entry["figure"];
    if (metric != "rugosity") return metric;
    const long resolution_mm = std::lround(1e3 * entry["resolution_m"].get<double>());
    return metric + " at " + std::to_string(resolution_mm) + " mm";
}

DiveSamples samples_of(const SimulatedDive& dive, const Options& options) {
    const SimulatedDives dives{options.program, options.cache};
    const fs::path model = options.keep / ("sim-" + dive.name());
    if (!fs::exists(model / "metrics.json")) dives.reconstruct(dive, model);
    const fs::path folder = dives.rendered(dive);
    const TrueSurface surface = true_surface(folder);
    const evaluation::SurfaceIndex index(surface.mesh);
    const std::vector<KnownSquare> squares = known_squares(
        surface.mesh, in_truth_frame(io::read_ply(model / "mesh.ply"), model, folder));
    DiveSamples samples;
    if (squares.empty()) return samples;
    const json answer = measured(squares, model, folder, options);
    for (const json& entry : answer["figures"]) {
        const auto square = std::find_if(squares.begin(), squares.end(), [&](const auto& known) {
            return known.name == entry["area"];
        });
        if (square == squares.end() || entry.contains("refused")) continue;
        if (const auto truth = truth_of(entry["figure"], entry, *square, surface, index))
            samples[label_of(entry)].push_back(
                {square->name, entry["value"], entry["low"], entry["high"], *truth});
    }
    return samples;
}

double mean_of(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

// Summarises the squares of one dive or of many.
json summary(const std::vector<Sample>& samples) {
    std::vector<double> errors, widths, held, squares;
    for (const Sample& sample : samples) {
        errors.push_back(sample.error() / sample.truth);
        widths.push_back(0.5 * (sample.high - sample.low) / sample.truth);
        held.push_back(sample.is_held() ? 1.0 : 0.0);
        squares.push_back(sample.deviations() * sample.deviations());
    }
    return {{"num_squares", samples.size()},
            {"held", mean_of(held)},
            {"median_error", stats::upper_median(errors)},
            {"mean_error", mean_of(errors)},
            {"median_half_width", stats::upper_median(widths)},
            {"error_rms_sigmas", std::sqrt(mean_of(squares))}};
}

json each_of(const std::vector<Sample>& samples) {
    json squares = json::array();
    for (const Sample& sample : samples)
        squares.push_back({{"square", sample.square},
                           {"measured", sample.measured},
                           {"low", sample.low},
                           {"high", sample.high},
                           {"truth", sample.truth}});
    return squares;
}

struct Gathered {
    std::vector<Sample> squares;
    std::vector<double> held_by_dive;  // share of a dive's squares
    std::vector<double> error_by_dive;
};

json to_json(const Gathered& gathered) {
    json result = summary(gathered.squares);
    result["num_dives"] = gathered.held_by_dive.size();
    result["held_mean_of_dives"] = mean_of(gathered.held_by_dive);
    result["median_of_dives_mean_error"] = stats::upper_median(gathered.error_by_dive);
    return result;
}

json run(const Options& options) {
    json report = {{"machine", describe_machine()}, {"dives", json::array()}};
    std::map<std::string, Gathered> by_metric;
    for (const int seed : options.seeds)
        for (const SimulatedDive& dive : dives_of_seed(seed)) {
            if (std::find(options.scenes.begin(), options.scenes.end(), dive.scene) ==
                options.scenes.end())
                continue;
            std::cerr << dive.name() << std::endl;
            json metrics = json::object();
            for (const auto& [metric, samples] : samples_of(dive, options)) {
                const json of_dive = summary(samples);
                Gathered& gathered = by_metric[metric];
                gathered.squares.insert(gathered.squares.end(), samples.begin(), samples.end());
                gathered.held_by_dive.push_back(of_dive["held"]);
                gathered.error_by_dive.push_back(of_dive["mean_error"]);
                metrics[metric] = of_dive;
                if (options.each) metrics[metric]["squares"] = each_of(samples);
            }
            report["dives"].push_back({{"dive", dive.name()}, {"metrics", metrics}});
        }
    for (const auto& [metric, gathered] : by_metric) report["metrics"][metric] = to_json(gathered);
    return report;
}

}  // namespace
}  // namespace divemesh::bench

int main(int argc, char** argv) {
    using namespace divemesh;
    bench::Options options;
    options.scenes = {"tank", "barge", "reef"};
    int first_seed = 31, num_seeds = 5;
    CLI::App app{
        "Measures how often the intervals of reef metrics hold and prints one JSON document."};
    app.add_option("--program", options.program, "path of the divemesh program")->required();
    app.add_option("--cache", options.cache, "folder for rendered dives")->required()->take_last();
    app.add_option(
        "--first-seed", first_seed, "first seed; each seed gives three scenes and a loop");
    app.add_option("--seeds", num_seeds, "number of seeds")->check(CLI::Range(1, 1000));
    app.add_option("--scenes", options.scenes, "scenes to run: tank, barge, reef")->delimiter(',');
    app.add_option("--keep",
                   options.keep,
                   "leave reconstructions in this folder; what is there is measured as it is, "
                   "whatever program made it");
    app.add_flag("--each", options.each, "print the metrics of every square too");
    CLI11_PARSE(app, argc, argv);

    for (int i = 0; i < num_seeds; ++i) options.seeds.push_back(first_seed + i);
    const TemporaryFolder temporary;
    if (options.keep.empty()) options.keep = temporary.path();
    std::filesystem::create_directories(options.keep);
    std::cout << bench::run(options).dump(2) << "\n";
}
