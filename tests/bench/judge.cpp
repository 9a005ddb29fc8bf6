#include "tests/bench/judge.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "worker/stats/median.hpp"

namespace divemesh::bench {
namespace {

using nlohmann::json;

constexpr double kSimilarLife = 0.3;

// Returns the metric of a run without ablation; nullopt if it is missing.
std::optional<double> find_metric(const json& runs,
                                  const std::string& group,
                                  const std::string& dive,
                                  const std::string& preset,
                                  const std::string& metric) {
    for (const json& run : runs) {
        if (run["group"] != group || run["dive"] != dive || run["preset"] != preset ||
            run["ablation"] != "none")
            continue;
        const json metrics = run.value("metrics", json::object());
        if (metrics.contains(metric)) return metrics[metric].get<double>();
    }
    return std::nullopt;
}

const char* name_of(Goal::Over over) {
    switch (over) {
        case Goal::Over::Mean: return "mean";
        case Goal::Over::Median: return "median";
        case Goal::Over::Worst: break;
    }
    return "worst";
}

double condense(const Goal& goal, const std::vector<double>& values) {
    if (goal.over == Goal::Over::Median) return stats::median(values);
    if (goal.over == Goal::Over::Mean)
        return std::accumulate(values.begin(), values.end(), 0.0) /
               static_cast<double>(values.size());
    const auto [min, max] = std::minmax_element(values.begin(), values.end());
    return goal.at_most ? *max : *min;
}

}  // namespace

json judge(const Goal& goal, const json& runs) {
    std::vector<double> values;
    for (const std::string& dive : goal.dives)
        if (const auto value = find_metric(runs, goal.group, dive, goal.preset, goal.metric))
            values.push_back(std::abs(*value));
    json judged = {{"dives", goal.dives.size() == 1 ? json(goal.dives[0]) : json(goal.dives)},
                   {"preset", goal.preset},
                   {"metric", goal.metric},
                   {goal.at_most ? "at_most" : "at_least", goal.value},
                   {"measured", nullptr},
                   {"met", false}};
    if (goal.dives.size() > 1) {
        judged["over"] = name_of(goal.over);
        judged["num_dives_measured"] = values.size();
    }
    if (values.empty()) return judged;
    const double value = condense(goal, values);
    judged["measured"] = value;
    judged["met"] = values.size() == goal.dives.size() &&
                    (goal.at_most ? value <= goal.value : value >= goal.value);
    return judged;
}

json compare_track_life(const json& runs) {
    const auto life_of = [&](const std::string& dive) {
        return find_metric(runs, "trajectory", dive, "standard", "median_track_life_frames");
    };
    json result = {{"simulated_frames", json::object()}};
    std::vector<double> simulated;
    for (const Dive& dive : all_dives()) {
        if (!dive.simulated || dive.simulated->scene != "barge") continue;
        if (const auto life = life_of(dive.name)) {
            simulated.push_back(*life);
            result["simulated_frames"][dive.name] = *life;
        }
    }
    const auto shared = life_of("barge");
    if (!shared || simulated.empty()) return nullptr;
    const double ratio = stats::median(simulated) / *shared;
    result["barge_frames"] = *shared;
    result["ratio"] = ratio;
    result["within_30_percent"] = std::abs(ratio - 1.0) <= kSimilarLife;
    return result;
}

}  // namespace divemesh::bench
