#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

// What is run, what is read from each metrics.json, and what a release has to reach.
namespace divemesh::bench {

// A dive of the shared data, or one that `divemesh simulate` renders.
struct Dive {
    struct Simulated {
        std::string scene;
        int seed = 0;
    };
    std::string name;
    std::optional<Simulated> simulated;
};

// A change of the options that tells what one part of the estimation is worth; "none": as it is.
struct Ablation {
    std::string name;
    nlohmann::json options;  // by name
};

struct Run {
    std::string group;  // trajectory, surface, speed
    Dive dive;
    std::string preset;
    Ablation ablation;
};

// A figure by its place in metrics.json.
struct Metric {
    const char* name;
    const char* pointer;
};

// A figure over some dives that a release has to reach; the absolute value counts.
struct Goal {
    enum class Over { Mean, Median, Worst };
    std::string group;
    std::vector<std::string> dives;
    std::string preset;
    std::string metric;
    Over over = Over::Worst;
    bool at_most = true;  // else at least
    double value = 0.0;
};

const std::vector<Dive>& all_dives();
const std::vector<std::string>& all_presets();
const std::vector<Ablation>& all_ablations();
// The runs of one group: of the trajectory every preset on every dive, and with the preset
// `standard` every ablation.
std::vector<Run> runs_of(const std::string& group);
const std::vector<Goal>& all_goals();
const std::vector<Metric>& all_metrics();

}  // namespace divemesh::bench
