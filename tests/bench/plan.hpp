#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

// The runs of the bench, the metrics that it reads from each metrics.json, and the goals of a
// release.
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

// A change of options that switches off one part of the estimation, to show what that part
// contributes. "none" changes no option.
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

// A metric and its JSON pointer in metrics.json.
struct Metric {
    const char* name;
    const char* pointer;
};

// The value that a release has to reach for a metric over some dives. Absolute values are compared.
struct Goal {
    enum class Over { Mean, Median, Worst };
    std::string group;
    std::vector<std::string> dives;
    std::string preset;
    std::string metric;
    Over over = Over::Worst;
    bool at_most = true;  // false: at least
    double value = 0.0;
};

const std::vector<Dive>& all_dives();
const std::vector<std::string>& all_presets();
const std::vector<Ablation>& all_ablations();
// Returns the runs of a group. The group `trajectory` runs every preset on every dive, and every
// ablation with the preset `standard`. Of the others only `surface` runs simulated dives, with
// `standard`.
std::vector<Run> runs_of(const std::string& group);
const std::vector<Goal>& all_goals();
const std::vector<Metric>& all_metrics();

}  // namespace divemesh::bench
