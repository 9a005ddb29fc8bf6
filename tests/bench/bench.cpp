// Runs the shared dives through `divemesh reconstruct` and prints one JSON of what came out.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/bench/machine.hpp"
#include "tests/bench/plan.hpp"
#include "tests/paths.hpp"
#include "tests/temporary_folder.hpp"

extern char** environ;

namespace divemesh::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct Options {
    std::vector<std::string> only = {"trajectory", "surface", "speed"};
    std::vector<std::string> dives;  // empty: all
    int num_repeats = 3;             // of the runs that measure speed
    bool require = false;
    fs::path program;
    fs::path keep;  // results stay here; "": nowhere
};

bool contains(const std::vector<std::string>& list, const std::string& item) {
    return std::find(list.begin(), list.end(), item) != list.end();
}

// Exit code of the program; what it prints goes to `log`.
int run_program(std::vector<std::string> words, const fs::path& log) {
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(
        &actions, STDOUT_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
    pid_t child = 0;
    const int failure =
        posix_spawn(&child, arguments[0], &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failure != 0) return 127;
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
}

std::string last_lines(const fs::path& log) {
    std::ifstream stream(log);
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    return text.size() > 600 ? text.substr(text.size() - 600) : text;
}

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    const std::size_t middle = values.size() / 2;
    return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

// The median of each figure over the documents that have it.
json median_figures(const std::vector<json>& documents) {
    json figures = json::object();
    for (const Figure& figure : kFigures) {
        const json::json_pointer pointer(figure.pointer);
        std::vector<double> values;
        for (const json& document : documents)
            if (document.contains(pointer) && document[pointer].is_number())
                values.push_back(document[pointer].get<double>());
        if (!values.empty()) figures[figure.name] = median(values);
    }
    return figures;
}

json reconstruct(const Run& run, int num_repeats, const Options& options, const fs::path& folder) {
    json result = {{"dive", run.dive}, {"preset", run.preset}};
    std::vector<json> documents;
    for (int repeat = 0; repeat < num_repeats; ++repeat) {
        const fs::path out = folder / (run.dive + "-" + run.preset);
        const fs::path log = folder / (run.dive + "-" + run.preset + ".log");
        std::cerr << run.dive << ", " << run.preset << ", " << repeat + 1 << " of " << num_repeats
                  << "\n";
        const int code = run_program({options.program.string(),
                                      "reconstruct",
                                      shared_data(run.dive).string(),
                                      "--out",
                                      out.string(),
                                      "--preset",
                                      run.preset},
                                     log);
        if (code != 0) {
            result["failed"] = {{"exit_code", code}, {"output", last_lines(log)}};
            return result;
        }
        documents.push_back(json::parse(std::ifstream(out / "metrics.json")));
    }
    result["num_repeats"] = num_repeats;
    result["figures"] = median_figures(documents);
    result["stages"] = documents.back()["speed"]["stages"];
    return result;
}

// What is not measured (an absent dive, a failed run) is not met.
json judge(const Goal& goal, const json& runs) {
    json judged = {{"dive", goal.dive},
                   {"preset", goal.preset},
                   {"figure", goal.figure},
                   {goal.at_most ? "at_most" : "at_least", goal.value},
                   {"measured", nullptr},
                   {"met", false}};
    for (const json& run : runs) {
        if (run["dive"] != goal.dive || run["preset"] != goal.preset) continue;
        const json figures = run.value("figures", json::object());
        if (!figures.contains(goal.figure)) continue;
        const double value = figures[goal.figure].get<double>();
        judged["measured"] = value;
        judged["met"] =
            goal.at_most ? std::abs(value) <= goal.value : std::abs(value) >= goal.value;
    }
    return judged;
}

json run_all(const Options& options, const fs::path& folder) {
    json report = {{"machine", describe_machine()},
                   {"runs", json::array()},
                   {"goals", json::array()},
                   {"absent", json::array()}};
    for (const Run& run : kRuns) {
        const auto wanted = [&](const std::string& group) { return contains(options.only, group); };
        if (!options.dives.empty() && !contains(options.dives, run.dive)) continue;
        if (std::none_of(run.groups.begin(), run.groups.end(), wanted)) continue;
        if (!fs::exists(shared_data(run.dive))) {
            std::cerr << "absent: " << shared_data(run.dive).string()
                      << " (DIVEMESH_SHARED says where the shared data are)\n";
            if (!std::count(report["absent"].begin(), report["absent"].end(), run.dive))
                report["absent"].push_back(run.dive);
            continue;
        }
        const bool for_speed = run.groups.contains("speed") && wanted("speed");
        report["runs"].push_back(
            reconstruct(run, for_speed ? options.num_repeats : 1, options, folder));
    }
    for (const Goal& goal : kGoals)
        if (contains(options.only, goal.group) &&
            (options.dives.empty() || contains(options.dives, goal.dive)))
            report["goals"].push_back(judge(goal, report["runs"]));
    return report;
}

int exit_code(const json& report, const Options& options) {
    for (const json& run : report["runs"])
        if (run.contains("failed")) return 1;
    for (const json& goal : report["goals"])
        if (options.require && !goal["met"].get<bool>()) return 3;
    return 0;
}

}  // namespace
}  // namespace divemesh::bench

int main(int argc, char** argv) {
    using namespace divemesh;
    bench::Options options;
    CLI::App app{"Reconstructs the shared dives and prints the figures as one JSON."};
    app.add_option("--only", options.only, "trajectory, surface, speed; default: all of them")
        ->delimiter(',')
        ->check(CLI::IsMember({"trajectory", "surface", "speed"}));
    app.add_option("--dive", options.dives, "names of dives; default: all")->delimiter(',');
    app.add_option("--repeat", options.num_repeats, "runs that measure speed; the median counts")
        ->check(CLI::Range(1, 100));
    app.add_flag("--require", options.require, "exit 3 when a goal is not met");
    app.add_option("--program", options.program, "the divemesh to run")->required();
    app.add_option("--keep", options.keep, "leave the results in this folder");
    CLI11_PARSE(app, argc, argv);

    const TemporaryFolder temporary;
    if (!options.keep.empty()) std::filesystem::create_directories(options.keep);
    const auto report =
        bench::run_all(options, options.keep.empty() ? temporary.path() : options.keep);
    std::cout << report.dump(2) << "\n";
    return bench::exit_code(report, options);
}
