// Dense stereo of real images beside OpenCV's: how much of an image gets a depth, and how right it
// is where the truth is known. Prints one JSON.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/machine.hpp"
#include "tests/bench/stereo_coverage.hpp"
#include "tests/bench/stereo_pairs.hpp"
#include "tests/paths.hpp"

namespace divemesh::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// The shared recordings: real ones and the two rendered ones.
std::vector<fs::path> all_recordings() {
    std::vector<fs::path> dives;
    for (const char* name : {"tank", "barge", "euroc_mh01"}) dives.push_back(shared_data(name));
    const fs::path real = shared_data("real");
    if (fs::exists(real))
        for (const auto& entry : fs::directory_iterator(real))
            if (entry.is_directory()) dives.push_back(entry.path());
    std::sort(dives.begin(), dives.end());
    return dives;
}

void outline(const json& result) {
    std::cerr << result["dive"].get<std::string>() << ": own " << result["own"].get<double>()
              << ", sgbm " << result["sgbm"].get<double>() << ", ms "
              << result["own_cpu_ms"].get<double>() << " / " << result["sgbm_cpu_ms"].get<double>()
              << std::endl;
}

}  // namespace
}  // namespace divemesh::bench

int main(int argc, char** argv) {
    using namespace divemesh;
    std::vector<std::filesystem::path> dives;
    std::vector<std::string> only = {"coverage", "middlebury"};
    bench::CoverageOptions options;
    CLI::App app{
        "Compares dense stereo with OpenCV's and prints the metrics as one JSON document."};
    app.add_option("--dive", dives, "folders of recordings; default: those of the shared data");
    app.add_option("--only", only, "parts to run; default: both")
        ->delimiter(',')
        ->check(CLI::IsMember({"coverage", "middlebury"}));
    app.add_option(
           "--pairs", options.num_pairs, "number of pairs of each recording, spread over it")
        ->check(CLI::Range(1, 1000));
    app.add_option(
        "--num-disparities", options.num_disparities_px, "number of disparities of both matchers");
    app.add_option("--images", options.images, "folder for images of the disparities");
    CLI11_PARSE(app, argc, argv);

    const auto wanted = [&](const char* part) {
        return std::find(only.begin(), only.end(), part) != only.end();
    };
    nlohmann::json report = {{"machine", bench::describe_machine()}};
    if (wanted("coverage"))
        for (const auto& dive : dives.empty() ? bench::all_recordings() : dives) {
            if (!std::filesystem::exists(dive)) {
                report["absent"].push_back(dive.filename().string());
                continue;
            }
            report["coverage"].push_back(bench::compare_coverage(dive, options));
            bench::outline(report["coverage"].back());
        }
    if (wanted("middlebury"))
        report["middlebury"] = bench::compare_under_conditions(shared_data("middlebury"));
    std::cout << report.dump(2) << "\n";
}
