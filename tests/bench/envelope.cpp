// Where reconstruction ends: walks each axis along which dives get harder, by itself, until it
// breaks. Prints one JSON; the table goes to stderr or to a file.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "tests/bench/envelope_judge.hpp"
#include "tests/bench/envelope_plan.hpp"
#include "tests/bench/envelope_plot.hpp"
#include "tests/bench/envelope_runs.hpp"
#include "tests/bench/envelope_summary.hpp"
#include "tests/bench/envelope_table.hpp"
#include "tests/bench/machine.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// An ordered axis ends after so many steps that do not work: one shows the edge, the next whether
// failing is said too.
constexpr int kStepsBeyondEdge = 2;

struct Options {
    fs::path program;
    fs::path cache;
    fs::path keep;  // "": results are not kept
    fs::path table;
    fs::path plot;
    bool quick = false;
    bool sift = true;
    int width_px = 320;
    std::vector<std::string> axes;    // empty: all
    std::vector<std::string> steps;   // of these axes, by label; empty: all
    std::vector<std::string> scenes;  // empty: those of the scale
    std::vector<int> seeds;           // likewise
    double length_m = 0.0;            // of the plain dive; 0: that of the scale
};

bool is_wanted(const std::string& name, const std::vector<std::string>& wanted) {
    return wanted.empty() || std::find(wanted.begin(), wanted.end(), name) != wanted.end();
}

EnvelopeScale scale_of(const Options& options) {
    EnvelopeScale scale = options.quick ? quick_envelope() : whole_envelope();
    scale.sift = options.sift;
    scale.width_px = options.width_px;
    scale.height_px = 3 * options.width_px / 4;
    if (!options.scenes.empty()) scale.scenes = options.scenes;
    if (!options.seeds.empty()) scale.seeds = options.seeds;
    if (options.length_m > 0.0) scale.plain_length_m = options.length_m;
    return scale;
}

void walk(
    const EnvelopeAxis& axis, const std::string& scene, int seed, EnvelopeRuns& runs, json& found) {
    int num_broken = 0;
    for (const EnvelopeStep& step : axis.steps) {
        if (axis.ordered && num_broken == kStepsBeyondEdge) return;
        const EnvelopeRun run{axis, step, scene, seed};
        std::cerr << run.name() << std::flush;
        found.push_back(runs.measured(run));
        const bool good = works(found.back());
        std::cerr << (good ? ": works" : ": breaks") << std::endl;
        num_broken = good ? 0 : num_broken + 1;
    }
}

json walk_all(const EnvelopeAxis& axis, const EnvelopeScale& scale, EnvelopeRuns& runs) {
    json found = json::array();
    const auto scenes = axis.scene.empty() ? scale.scenes : std::vector<std::string>{axis.scene};
    for (const std::string& scene : scenes)
        for (const int seed : scale.seeds) walk(axis, scene, seed, runs, found);
    return found;
}

json edge(const EnvelopeAxis& axis, const json& runs) {
    std::vector<std::string> steps;
    for (const EnvelopeStep& step : axis.steps) steps.push_back(step.label);
    json result = edge_of(steps, runs);
    result["axis"] = axis.name;
    return result;
}

json report(const Options& options, const fs::path& results) {
    const EnvelopeScale scale = scale_of(options);
    EnvelopeRuns runs(options.program, options.cache, results, scale);
    json result = {{"machine", describe_machine()},
                   {"num_runs", 0},
                   {"edges", json::array()},
                   {"steps", json::array()},
                   {"beyond", json::array()},
                   {"silent", json::array()},
                   {"hollow", json::array()},
                   {"runs", json::array()}};
    for (EnvelopeAxis axis : envelope_axes()) {
        if (!is_wanted(axis.name, options.axes)) continue;
        std::erase_if(axis.steps, [&](const EnvelopeStep& step) {
            return !is_wanted(step.label, options.steps);
        });
        const json of_axis = walk_all(axis, scale, runs);
        if (axis.ordered) result["edges"].push_back(edge(axis, of_axis));
        for (json& row : summarise(axis, of_axis)) result["steps"].push_back(std::move(row));
        for (const json& run : of_axis) {
            if (breaks_bound(run)) result["beyond"].push_back(run);
            if (is_silent(run)) result["silent"].push_back(run);
            if (is_hollow_success(run)) result["hollow"].push_back(run);
            result["runs"].push_back(run);
        }
    }
    result["num_runs"] = result["runs"].size();
    return result;
}

void write(const std::string& text, const fs::path& file) {
    std::ofstream stream(file);
    stream << text;
    if (!stream.flush()) throw std::runtime_error("cannot write " + file.string());
}

std::vector<std::string> ordered_axes() {
    std::vector<std::string> names;
    for (const EnvelopeAxis& axis : envelope_axes())
        if (axis.ordered) names.push_back(axis.name);
    return names;
}

void run(const Options& options, const fs::path& results) {
    const json result = report(options, results);
    std::cout << result.dump(2) << "\n";
    const std::string table = envelope_table(result);
    if (options.table.empty())
        std::cerr << table;
    else
        write(table, options.table);
    if (!options.plot.empty()) write(envelope_plot(result["steps"], ordered_axes()), options.plot);
}

}  // namespace
}  // namespace divemesh::bench

int main(int argc, char** argv) {
    using namespace divemesh;
    bench::Options options;
    CLI::App app{
        "Makes dives harder along each axis until reconstruction fails, and prints one JSON "
        "document."};
    app.add_option("--program", options.program, "path of the divemesh program")->required();
    app.add_option("--cache", options.cache, "folder for rendered dives")->required()->take_last();
    app.add_flag("--quick", options.quick, "one scene, one seed, short dives");
    app.add_flag("!--no-sift", options.sift, "leave out the baseline with SIFT and PnP");
    app.add_option("--width-px", options.width_px, "image width; images are 4:3")
        ->capture_default_str()
        ->check(CLI::Range(64, 4096));
    app.add_option("--axis", options.axes, "only these axes, by name")->delimiter(',');
    app.add_option("--step", options.steps, "only these steps, by label")->delimiter(',');
    app.add_option("--scenes", options.scenes, "scenes instead of the two default ones")
        ->delimiter(',');
    app.add_option("--seeds", options.seeds, "seeds instead of the three default ones")
        ->delimiter(',');
    app.add_option("--length-m", options.length_m, "path length of the dives that steps alter")
        ->check(CLI::Range(1.0, 1000.0));
    app.add_option("--keep",
                   options.keep,
                   "folder for results; runs that have a result there are not repeated");
    app.add_option("--table", options.table, "write the table to this Markdown file");
    app.add_option("--plot", options.plot, "write the plot to this SVG");
    CLI11_PARSE(app, argc, argv);
    try {
        const TemporaryFolder temporary;
        bench::run(options, options.keep.empty() ? temporary.path() : options.keep);
    } catch (const std::exception& error) {
        std::cerr << error.what() << "\n";
        return 1;
    }
}
