// Runs dives through `divemesh reconstruct` and prints one JSON of what came out.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

#include "tests/bench/dive_folder.hpp"
#include "tests/bench/judge.hpp"
#include "tests/bench/kept_results.hpp"
#include "tests/bench/klt_baseline.hpp"
#include "tests/bench/machine.hpp"
#include "tests/bench/plan.hpp"
#include "tests/bench/program.hpp"
#include "tests/bench/sgbm_baseline.hpp"
#include "tests/bench/stereo_pairs.hpp"
#include "tests/paths.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Names = std::vector<std::string>;

const Names kGroups = {"trajectory", "surface", "speed"};
constexpr int kNumThreads = 2;                  // of the runs that measure speed
constexpr int kSgbmStride = 5;                  // every fifth pair says what OpenCV's matcher takes
const std::string kStereoPairs = "middlebury";  // matched beside the dives, by `standard`

struct Options {
    Names only = kGroups;
    Names dives;          // empty: all
    Names presets;        // empty: all
    Names ablations;      // empty: all
    int num_repeats = 3;  // of the runs that measure speed
    bool require = false;
    fs::path program;
    fs::path cache;  // of rendered dives
    fs::path keep;   // results stay here, and those that are here already count; "": nowhere
};

bool wanted(const Names& list, const std::string& item) {
    return list.empty() || std::find(list.begin(), list.end(), item) != list.end();
}

// The median of each metric over the documents that have it.
json median_metrics(const std::vector<json>& documents) {
    json named_values = json::object();
    for (const Metric& metric : all_metrics()) {
        const json::json_pointer pointer(metric.pointer);
        std::vector<double> values;
        for (const json& document : documents)
            if (document.contains(pointer) && document[pointer].is_number())
                values.push_back(document[pointer].get<double>());
        if (!values.empty()) named_values[metric.name] = stats::median(values);
    }
    return named_values;
}

// Returns the time of the stages that a trajectory needs. With surface=false only the pairwise
// estimator matches densely in them.
double cpu_ms_per_frame(const json& metrics) {
    double cpu_s = 0.0;
    for (const json& stage : metrics["speed"]["stages"])
        if (stage["stage"] == "align" || stage["stage"] == "track" || stage["stage"] == "optimise")
            cpu_s += stage["cpu_s"].get<double>();
    return 1e3 * cpu_s / std::max(1.0, metrics["frames"]["num_frames"].get<double>());
}

void add_trajectory_metrics(const json& metrics, json& result) {
    json& named_values = result["metrics"];
    named_values["cpu_ms_per_frame"] = cpu_ms_per_frame(metrics);
    if (named_values.contains("ate_rmse_m"))
        named_values["ate_percent_of_path"] = 100.0 * named_values["ate_rmse_m"].get<double>() /
                                              named_values["path_length_m"].get<double>();
    for (const char* which : {"final", "causal"}) {
        const json::json_pointer pointer(std::string("/trajectory/") + which + "/segments");
        if (metrics.contains(pointer)) result["segments"][which] = metrics[pointer];
    }
}

Names words_of(const Run& run, const fs::path& dive, const fs::path& out, const Options& options) {
    Names words = {options.program.string(),
                   "reconstruct",
                   dive.string(),
                   "--out",
                   out.string(),
                   "--preset",
                   run.preset};
    json overrides = run.ablation.options;
    if (run.group == "trajectory") overrides["surface"] = false;
    if (run.group == "speed")
        words.insert(words.end(), {"--no-texture", "--threads", std::to_string(kNumThreads)});
    for (const auto& [name, value] : overrides.items())
        words.insert(
            words.end(),
            {"--set", name + "=" + (value.is_string() ? value.get<std::string>() : value.dump())});
    return words;
}

std::string name_of(const Run& run) {
    return run.group + "-" + run.dive.name + "-" + run.preset + "-" + run.ablation.name;
}

// Its metrics.json; nothing when it failed, which `result` then says.
std::optional<json> run_once(const Run& run,
                             const fs::path& dive,
                             const Options& options,
                             const fs::path& folder,
                             json& result) {
    const std::string name = name_of(run);
    const fs::path log = folder / (name + ".log");
    const int code = run_program(words_of(run, dive, folder / name, options), log);
    if (code == 0) return json::parse(std::ifstream(folder / name / "metrics.json"));
    result["failed"] = {{"exit_code", code}, {"output", last_lines(log)}};
    return std::nullopt;
}

// Measures a dive as divers bring it, from start to exit, beside OpenCV's matcher alone. They take
// turns, so that other load on the machine burdens both.
json measure_speed(const Run& run,
                   const fs::path& dive,
                   const Options& options,
                   const fs::path& folder,
                   json result) {
    const fs::path bare = folder / (name_of(run) + ".dive");
    copy_without_truth(dive, bare);
    std::vector<json> documents;
    std::vector<double> wall_ms, sgbm_ms, ratios;
    for (int repeat = 0; repeat < options.num_repeats; ++repeat) {
        sgbm_ms.push_back(sgbm_ms_per_frame(bare, kSgbmStride));
        const auto start = std::chrono::steady_clock::now();
        const auto document = run_once(run, bare, options, folder, result);
        const std::chrono::duration<double, std::milli> taken =
            std::chrono::steady_clock::now() - start;
        if (!document) return result;
        documents.push_back(*document);
        wall_ms.push_back(taken.count() / (*document)["frames"]["num_frames"].get<double>());
        ratios.push_back(wall_ms.back() / sgbm_ms.back());
    }
    result["metrics"] = median_metrics(documents);
    result["metrics"]["wall_ms_per_frame"] = stats::median(wall_ms);
    result["metrics"]["sgbm_ms_per_frame"] = stats::median(sgbm_ms);
    result["metrics"]["wall_to_sgbm"] = stats::median(ratios);
    result["stages"] = documents.back()["speed"]["stages"];
    result["num_repeats"] = options.num_repeats;
    return result;
}

json reconstruct(const Run& run,
                 const fs::path& dive,
                 const Options& options,
                 const fs::path& folder) {
    json result = {{"group", run.group},
                   {"dive", run.dive.name},
                   {"preset", run.preset},
                   {"ablation", run.ablation.name}};
    if (run.group == "speed") return measure_speed(run, dive, options, folder, result);
    const auto document = run_once(run, dive, options, folder, result);
    if (!document) return result;
    result["metrics"] = median_metrics({*document});
    result["stages"] = (*document)["speed"]["stages"];
    if (run.group == "trajectory") add_trajectory_metrics(*document, result);
    return result;
}

// A cost against that of the least that has to be done, measured beside it.
void add_klt_baseline(const Run& run, const fs::path& dive, json& result) {
    const bool real_cost = run.group == "trajectory" && !run.dive.simulated &&
                           run.preset == "standard" && run.ablation.name == "none";
    if (!real_cost || !result.contains("metrics")) return;
    json& named_values = result["metrics"];
    named_values["klt_cpu_ms_per_frame"] = klt_cpu_ms_per_frame(dive);
    named_values["cpu_to_klt"] = named_values["cpu_ms_per_frame"].get<double>() /
                                 named_values["klt_cpu_ms_per_frame"].get<double>();
}

// By name, as the program that is measured has them: it may be of another version.
json options_of(const fs::path& program, const fs::path& folder) {
    const fs::path answer = folder / "options.json";
    if (run_program({program.string(), "--json", "reconstruct", "--explain"}, answer, true) != 0)
        throw std::runtime_error("does not run: " + program.string());
    return json::parse(std::ifstream(answer));
}

// Without the options that the program does not know; nothing when none of them is left.
std::optional<Ablation> known_part(const Ablation& ablation, const json& known_options) {
    Ablation result{ablation.name, json::object()};
    for (const auto& [name, value] : ablation.options.items())
        if (known_options.contains(name)) result.options[name] = value;
    if (result.options.empty() && !ablation.options.empty()) return std::nullopt;
    return result;
}

std::vector<Run> plan_runs(const Options& options, const json& known_options) {
    std::vector<Run> runs;
    for (const std::string& group : options.only)
        for (const Run& run : runs_of(group)) {
            const auto ablation = known_part(run.ablation, known_options);
            if (ablation && wanted(options.dives, run.dive.name) &&
                wanted(options.presets, run.preset) && wanted(options.ablations, ablation->name))
                runs.push_back({run.group, run.dive, run.preset, *ablation});
        }
    return runs;
}

// One line for who waits.
std::string outline(const json& result) {
    if (result.contains("failed")) return "failed: " + result["failed"].dump();
    std::string line;
    for (const auto& [metric, value] : result["metrics"].items())
        if (metric.find("ate_rmse_m") != std::string::npos || metric == "coverage" ||
            metric == "accuracy_median_m" || metric == "cpu_ms_per_frame")
            line += (line.empty() ? "" : ", ") + metric + " " + value.dump();
    return line;
}

json measure_all(const Options& options, const fs::path& folder, Names& absent) {
    const auto runs = plan_runs(options, options_of(options.program, folder));
    const KeptResults kept(folder, options.program);
    json results = json::array();
    for (std::size_t i = 0; i < runs.size(); ++i) {
        const Run& run = runs[i];
        if (std::count(absent.begin(), absent.end(), run.dive.name) > 0) continue;
        std::cerr << "[" << i + 1 << "/" << runs.size() << "] " << name_of(run) << std::endl;
        auto result = kept.find(name_of(run));
        if (!result) {
            const auto dive = dive_folder(run.dive, options.program, options.cache);
            if (!dive) {
                absent.push_back(run.dive.name);
                continue;
            }
            result = reconstruct(run, *dive, options, folder);
            add_klt_baseline(run, *dive, *result);
            if (!result->contains("failed")) kept.keep(name_of(run), *result);
        }
        std::cerr << "    " << outline(*result) << std::endl;
        results.push_back(std::move(*result));
    }
    return results;
}

void add_stereo_pairs(const Options& options, json& runs, Names& absent) {
    if (!wanted(options.only, "surface") || !wanted(options.presets, "standard") ||
        !wanted(options.dives, kStereoPairs))
        return;
    const json run = compare_on_stereo_pairs(shared_data(kStereoPairs));
    if (run.is_null())
        absent.push_back(kStereoPairs);
    else
        runs.push_back(run);
}

json run_all(const Options& options, const fs::path& folder) {
    json report = {{"machine", describe_machine()}, {"goals", json::array()}};
    Names absent;
    report["runs"] = measure_all(options, folder, absent);
    add_stereo_pairs(options, report["runs"], absent);
    report["absent"] = absent;
    report["track_life"] = compare_track_life(report["runs"]);
    for (const Goal& goal : all_goals()) {
        const auto asked = [&](const std::string& dive) { return wanted(options.dives, dive); };
        if (wanted(options.only, goal.group) && wanted(options.presets, goal.preset) &&
            wanted(options.ablations, "none") &&
            std::all_of(goal.dives.begin(), goal.dives.end(), asked))
            report["goals"].push_back(judge(goal, report["runs"]));
    }
    return report;
}

int exit_code(const json& report, const Options& options) {
    for (const json& run : report["runs"])
        if (run.contains("failed")) return 1;
    for (const json& goal : report["goals"])
        if (options.require && !goal["met"].get<bool>()) return 3;
    return 0;
}

template <typename Items>
Names names_of(const Items& items) {
    Names names;
    for (const auto& item : items) names.push_back(item.name);
    return names;
}

}  // namespace
}  // namespace divemesh::bench

int main(int argc, char** argv) {
    using namespace divemesh;
    bench::Options options;
    CLI::App app{"Reconstructs dives and prints the metrics as one JSON document."};
    const auto choose =
        [&](const char* flag, auto& list, const bench::Names& known, const char* text) {
            app.add_option(flag, list, text)->delimiter(',')->check(CLI::IsMember(known));
        };
    choose("--only", options.only, bench::kGroups, "groups of runs to do; default: all");
    bench::Names dives = bench::names_of(bench::all_dives());
    dives.push_back(bench::kStereoPairs);
    choose("--dive", options.dives, dives, "dives to run; default: all");
    choose("--preset", options.presets, bench::all_presets(), "presets to run; default: all");
    choose("--ablation",
           options.ablations,
           bench::names_of(bench::all_ablations()),
           "ablations of the group trajectory; none: the unchanged preset; default: all");
    app.add_option(
           "--repeat", options.num_repeats, "number of runs that measure speed; takes their median")
        ->check(CLI::Range(1, 100));
    app.add_flag("--require", options.require, "exit with 3 if a goal is not met");
    app.add_option("--program", options.program, "path of the divemesh program")->required();
    app.add_option("--cache", options.cache, "folder for rendered dives")->required()->take_last();
    app.add_option("--keep",
                   options.keep,
                   "folder for results; runs that have a result there are not repeated");
    CLI11_PARSE(app, argc, argv);

    const TemporaryFolder temporary;
    if (!options.keep.empty()) std::filesystem::create_directories(options.keep);
    const auto report =
        bench::run_all(options, options.keep.empty() ? temporary.path() : options.keep);
    std::cout << report.dump(2) << "\n";
    return bench::exit_code(report, options);
}
