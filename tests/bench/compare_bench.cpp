// What `divemesh compare` takes: time and memory by the number of vertices, and how long it needs
// to refuse two places that have nothing in common. Prints one JSON.

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "tests/bench/machine.hpp"
#include "tests/bench/program.hpp"

namespace {

namespace fs = std::filesystem;
using divemesh::bench::last_lines;
using divemesh::bench::ProgramUsage;
using divemesh::bench::run_measured;
using nlohmann::json;

struct Options {
    std::vector<std::size_t> vertices = {625'000, 2'500'000, 10'000'000};
    std::size_t refused_vertices = 900'000;
    int num_threads = 2;
    fs::path program;
    fs::path maker;
    fs::path cache;
};

// Made once; what changes there.
json make_model(
    const Options& options, const fs::path& folder, int seed, std::size_t num, int year) {
    const fs::path answer = folder.string() + ".json";
    if (!fs::exists(answer)) {
        fs::create_directories(folder);
        const fs::path part = folder.string() + ".part";
        const int code = divemesh::bench::run_program({options.maker.string(),
                                                       "--out",
                                                       folder.string(),
                                                       "--seed",
                                                       std::to_string(seed),
                                                       "--vertices",
                                                       std::to_string(num),
                                                       "--year",
                                                       std::to_string(year)},
                                                      part);
        if (code != 0) throw std::runtime_error("no model: " + last_lines(part));
        fs::rename(part, answer);
    }
    return json::parse(std::ifstream(answer));
}

fs::path model_folder(const Options& options, int seed, std::size_t num, int year) {
    return options.cache / ("place" + std::to_string(seed) + "-" + std::to_string(num) + "-year" +
                            std::to_string(year));
}

ProgramUsage compare(const Options& options, const fs::path& a, const fs::path& b) {
    return run_measured({options.program.string(),
                         "compare",
                         a.string(),
                         b.string(),
                         "--out",
                         (options.cache / "compared").string(),
                         "--threads",
                         std::to_string(options.num_threads)},
                        options.cache / "compared.log");
}

json usage_json(const ProgramUsage& usage) {
    return {{"cpu_s", usage.cpu_s},
            {"wall_s", usage.wall_s},
            {"peak_memory_bytes", usage.peak_memory_bytes}};
}

json with_truth(const json& total, double truth_m3) {
    const json& volume = total.at("volume_m3");
    return {{"truth_m3", truth_m3},
            {"volume_m3", volume},
            {"holds", volume.at("low") <= truth_m3 && truth_m3 <= volume.at("high")}};
}

json measure(const Options& options, std::size_t num) {
    const fs::path a = model_folder(options, 1, num, 1);
    const fs::path b = model_folder(options, 1, num, 2);
    const json truth = make_model(options, a, 1, num, 1);
    make_model(options, b, 1, num, 2);
    const ProgramUsage usage = compare(options, a, b);
    json result = usage_json(usage);
    result["num_vertices"] = truth.at("num_vertices");
    result["area_m2"] = truth.at("area_m2");
    if (usage.exit_code != 0) {
        result["failed"] = last_lines(options.cache / "compared.log");
        return result;
    }
    const json document = json::parse(std::ifstream(options.cache / "compared" / "compare.json"));
    result["method"] = document.at("registration").at("method");
    result["num_patches"] = document.at("patches").size();
    result["grown"] = with_truth(document.at("grown"), truth.at("grown_m3"));
    result["lost"] = with_truth(document.at("lost"), truth.at("lost_m3"));
    return result;
}

// To which power of the number of vertices the time grows from one run to the next.
json growth(const json& runs) {
    json powers = json::array();
    for (std::size_t i = 1; i < runs.size(); ++i) {
        const auto ratio = [&](const char* key) {
            return std::log(runs[i].at(key).get<double>() / runs[i - 1].at(key).get<double>());
        };
        powers.push_back(ratio("cpu_s") / ratio("num_vertices"));
    }
    return powers;
}

json measure_refusal(const Options& options) {
    const std::size_t num = options.refused_vertices;
    const fs::path here = model_folder(options, 1, num, 1);
    const fs::path elsewhere = model_folder(options, 2, num, 1);
    make_model(options, here, 1, num, 1);
    make_model(options, elsewhere, 2, num, 1);
    const ProgramUsage usage = compare(options, here, elsewhere);
    json result = usage_json(usage);
    result["num_vertices"] = num;
    result["refused"] = usage.exit_code == 1;
    result["said"] = last_lines(options.cache / "compared.log");
    return result;
}

}  // namespace

int main(int argc, char** argv) {
    Options options;
    CLI::App app{"Compares models of places with known change and prints one JSON document."};
    app.add_option("--vertices", options.vertices, "number of vertices of each compared model")
        ->delimiter(',');
    app.add_option("--refused-vertices",
                   options.refused_vertices,
                   "number of vertices of models of two different places; 0: skips them");
    app.add_option("--threads", options.num_threads)->capture_default_str();
    app.add_option("--program", options.program, "path of the divemesh program")->required();
    app.add_option("--cache", options.cache, "folder for models")->required()->take_last();
    CLI11_PARSE(app, argc, argv);
    options.maker = fs::canonical("/proc/self/exe").replace_filename("divemesh_compared_model");
    fs::create_directories(options.cache);
    json runs = json::array();
    for (const std::size_t num : options.vertices) {
        runs.push_back(measure(options, num));
        std::cerr << runs.back().dump() << std::endl;
    }
    json report = {{"machine", divemesh::bench::describe_machine()},
                   {"runs", runs},
                   {"power_of_vertices", growth(runs)}};
    if (options.refused_vertices > 0) report["refusal"] = measure_refusal(options);
    std::cout << report.dump(2) << "\n";
}
