#include "tests/bench/dive_folder.hpp"

#include <iostream>

#include "tests/bench/program.hpp"
#include "tests/paths.hpp"

namespace divemesh::bench {
namespace {

namespace fs = std::filesystem;

// A dive cut short never carries its final name.
bool render(const Dive& dive, const fs::path& program, const fs::path& folder) {
    const fs::path unfinished = folder.string() + ".part";
    const fs::path log = folder.string() + ".log";
    fs::create_directories(folder.parent_path());
    fs::remove_all(unfinished);
    std::vector<std::string> words = {program.string(),
                                      "simulate",
                                      "--scene",
                                      dive.simulated->scene,
                                      "--seed",
                                      std::to_string(dive.simulated->seed),
                                      "--length-m",
                                      "6",
                                      "--rate",
                                      "10",
                                      "--out",
                                      unfinished.string()};
    if (dive.simulated->scene != "tank") words.insert(words.end(), {"--water", "green"});
    if (run_program(words, log) != 0) {
        std::cerr << "not rendered: " << last_lines(log) << "\n";
        return false;
    }
    fs::rename(unfinished, folder);
    return true;
}

}  // namespace

std::optional<fs::path> dive_folder(const Dive& dive,
                                    const fs::path& program,
                                    const fs::path& cache) {
    const fs::path folder = dive.simulated ? cache / dive.name : shared_data(dive.name);
    if (fs::exists(folder)) return folder;
    if (!dive.simulated) {
        std::cerr << "absent: " << folder.string()
                  << " (DIVEMESH_SHARED says where the shared data are)\n";
        return std::nullopt;
    }
    std::cerr << dive.name << ": rendering it to " << folder.string() << "\n";
    if (!render(dive, program, folder)) return std::nullopt;
    return folder;
}

void copy_without_truth(const fs::path& dive, const fs::path& folder) {
    const bool has_root = fs::exists(dive / "mav0");
    const fs::path mav0 = has_root ? dive / "mav0" : dive;
    fs::remove_all(folder);
    fs::create_directories(folder / "mav0");
    for (const auto& entry : fs::directory_iterator(mav0))
        if (entry.path().filename() != "state_groundtruth_estimate0")
            fs::copy(entry.path(),
                     folder / "mav0" / entry.path().filename(),
                     fs::copy_options::recursive);
    if (has_root && fs::exists(dive / "dive.json"))
        fs::copy(dive / "dive.json", folder / "dive.json");
}

}  // namespace divemesh::bench
