// How true restored colours are: simulated dives, of which the reflectance of the surface and the
// water are known, are reconstructed with colours as recorded and restored. Prints one JSON.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/bench/color_truth.hpp"
#include "tests/bench/program.hpp"
#include "worker/simulator/simulate.hpp"
#include "worker/simulator/water.hpp"

namespace divemesh::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct Options {
    fs::path program;
    fs::path cache;
    fs::path keep;  // empty: beside the dives
    std::vector<std::string> scenes = {"barge", "reef", "transect"};
    std::vector<std::string> waters = {"clear", "green", "turbid"};
    double length_m = 4.0;
    int seed = 1;
    std::string preset = "fast";
};

void run_or_throw(const std::vector<std::string>& words, const fs::path& log) {
    if (run_program(words, log) != 0)
        throw std::runtime_error(log.filename().string() + ": " + last_lines(log));
}

// A dive to be rendered.
struct ColorDive {
    std::string scene;
    std::string water;
    int survey = 1;

    std::string name() const {
        return scene + "-" + water + (survey > 1 ? "-survey" + std::to_string(survey) : "");
    }
};

// Returns what of the options tells dives of one name apart.
std::string suffix_of(const Options& options) {
    return "-seed" + std::to_string(options.seed) + "-" + std::to_string(options.length_m) + "m";
}

fs::path rendered(const Options& options, const ColorDive& dive) {
    const fs::path folder = options.cache / ("color-" + dive.name() + suffix_of(options));
    if (fs::exists(folder)) return folder;
    const fs::path part = folder.string() + ".part";
    fs::remove_all(part);
    fs::create_directories(options.cache);
    run_or_throw({options.program.string(),
                  "simulate",
                  "--scene",
                  dive.scene,
                  "--water",
                  dive.water,
                  "--survey",
                  std::to_string(dive.survey),
                  "--seed",
                  std::to_string(options.seed),
                  "--length-m",
                  std::to_string(options.length_m),
                  "--width-px",
                  "480",
                  "--height-px",
                  "360",
                  "--rate",
                  "5",
                  "--out",
                  part.string()},
                 folder.string() + ".log");
    fs::rename(part, folder);
    return folder;
}

// Reconstructs dives, each at most once with the same options.
class Models {
public:
    // Refers to `options`.
    explicit Models(const Options& options) : options_(options) {}

    // Returns the folder of the model.
    fs::path reconstructed(const ColorDive& dive,
                           const std::string& color,
                           const std::string& white_point = "") {
        const fs::path base =
            options_.keep.empty() ? options_.cache / "color-models" : options_.keep;
        const fs::path out = base / (dive.name() + suffix_of(options_) + "-" + color +
                                     (white_point.empty() ? "" : "-white-point"));
        const auto made = white_point_of_.find(out);
        if (made != white_point_of_.end() && made->second == white_point) return out;
        fs::create_directories(base);
        std::vector<std::string> words = {options_.program.string(),
                                          "reconstruct",
                                          rendered(options_, dive).string(),
                                          "--preset",
                                          options_.preset,
                                          "--color",
                                          color,
                                          "--out",
                                          out.string()};
        if (!white_point.empty()) {
            words.emplace_back("--white-point");
            words.push_back(white_point);
        }
        run_or_throw(words, out.string() + ".log");
        white_point_of_[out] = white_point;
        return out;
    }

private:
    const Options& options_;
    std::map<fs::path, std::string> white_point_of_;  // of the models made, by their folders
};

json metrics_of(const fs::path& model) {
    return json::parse(std::ifstream(model / "metrics.json"));
}

// Returns the estimated coefficients beside the simulator's.
json coefficients(const json& color, const std::string& water_name) {
    const simulator::Water water =
        simulator::make_water(simulator::water_kind_from_string(water_name));
    json result = json::object();
    const char* channels[] = {"red", "green", "blue"};
    for (int c = 0; c < 3; ++c) {
        if (!color.contains(channels[c])) continue;
        const json& of = color.at(channels[c]);
        result[channels[c]] = {{"attenuation_per_m", of.at("attenuation_per_m")},
                               {"true_attenuation_per_m", water.attenuation_per_m[c]},
                               {"backscatter_per_m", of.at("backscatter_per_m")},
                               {"true_backscatter_per_m", water.backscatter_per_m[c]},
                               {"veil", of.at("veil")},
                               {"true_veil", water.veil[c] * water.exposure},
                               {"explained_share", of.at("explained_share")}};
    }
    return result;
}

json errors_of(const fs::path& model, const fs::path& dive, const AlbedoScene& scene) {
    const Eigen::Isometry3d T_scene_world = align_with_scene(model, dive);
    const auto squares = mosaic_pairs(MosaicSquares::of(model), scene, T_scene_world);
    const auto vertices = vertex_pairs(model, scene, T_scene_world);
    return {{"num_squares", squares.size()},
            {"texture_median_de2000", median_error(squares, true)},
            {"vertices_median_de2000", median_error(vertices, true)}};
}

json measure(const Options& options, const ColorDive& dive, Models& models) {
    const AlbedoScene scene(dive.scene, static_cast<std::uint64_t>(options.seed), options.length_m);
    const fs::path folder = rendered(options, dive);
    const fs::path restored = models.reconstructed(dive, "restored");
    const json color = metrics_of(restored).at("color");
    return {{"raw", errors_of(models.reconstructed(dive, "raw"), folder, scene)},
            {"restored", errors_of(restored, folder, scene)},
            {"outcome", color.at("outcome")},
            {"light", color.value("light", "")},
            {"explained_share", color.value("explained_share", 0.0)},
            {"limited_share", color.value("limited_share", 0.0)},
            {"vignetting", color.value("vignetting", 0.0)},
            {"range_m", {color.at("near_m"), color.at("far_m")}},
            {"channels", coefficients(color, dive.water)}};
}

// Two dives of one place in two waters, the second with the white point of the first.
json compare_dives(const Options& options, Models& models) {
    const ColorDive first{options.scenes.front(), "clear"};
    const ColorDive second{options.scenes.front(), "green", 2};
    const AlbedoScene scene(
        first.scene, static_cast<std::uint64_t>(options.seed), options.length_m);
    const auto difference = [&](const std::string& color, const std::string& white_point) {
        const fs::path one = models.reconstructed(first, color);
        const fs::path other = models.reconstructed(second, color, white_point);
        const auto pairs = common_pairs(MosaicSquares::of(one),
                                        align_with_scene(one, rendered(options, first)),
                                        MosaicSquares::of(other),
                                        align_with_scene(other, rendered(options, second)),
                                        scene);
        return json{{"num_squares", pairs.size()},
                    {"median_de2000", median_error(pairs, false)},
                    {"median_de2000_after_gains", median_error(pairs, true)}};
    };
    json result = {{"dives", {first.name(), second.name()}}, {"raw", difference("raw", "")}};
    const json color = metrics_of(models.reconstructed(first, "restored")).at("color");
    if (!color.contains("white_point")) return result;
    std::string white_point;
    for (const json& number : color.at("white_point"))
        white_point += (white_point.empty() ? "" : ",") + number.dump();
    result["white_point"] = white_point;
    result["restored"] = difference("restored", white_point);
    result["restored_each_by_itself"] = difference("restored", "");
    return result;
}

int run(int argc, char** argv) {
    Options options;
    CLI::App app("Compares restored colours of simulated dives with the truth.");
    app.add_option("--program", options.program, "divemesh")->required();
    app.add_option("--cache", options.cache, "folder of the dives")->required();
    app.add_option("--keep", options.keep, "folder of the models");
    app.add_option("--scenes", options.scenes, "barge, reef, transect")->delimiter(',');
    app.add_option("--waters", options.waters, "clear, green, turbid")->delimiter(',');
    app.add_option("--length-m", options.length_m, "of the paths");
    app.add_option("--seed", options.seed, "of the places");
    app.add_option("--preset", options.preset, "of the reconstructions");
    CLI11_PARSE(app, argc, argv);
    Models models(options);
    json result = json::object();
    for (const std::string& scene : options.scenes)
        for (const std::string& water : options.waters) {
            const ColorDive dive{scene, water};
            result["dives"][dive.name()] = measure(options, dive, models);
            std::fprintf(stderr,
                         "%s %s\n",
                         dive.name().c_str(),
                         result["dives"][dive.name()].dump().c_str());
        }
    result["two_waters"] = compare_dives(options, models);
    std::printf("%s\n", result.dump(2).c_str());
    return 0;
}

}  // namespace
}  // namespace divemesh::bench

int main(int argc, char** argv) try {
    return divemesh::bench::run(argc, argv);
} catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
