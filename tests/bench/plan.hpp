#pragma once

#include <set>
#include <string>
#include <vector>

namespace divemesh::bench {

// A dive of the shared data with a preset, and the groups (trajectory, surface, speed) it is for.
struct Run {
    std::string dive;
    std::string preset;
    std::set<std::string> groups;
};

// A figure of a run that a release has to reach; `figure` as in kFigures.
struct Goal {
    std::string dive;
    std::string preset;
    std::string group;
    std::string figure;
    bool at_most = true;  // else at least; of the absolute value
    double value = 0.0;
};

// A figure by its place in metrics.json.
struct Figure {
    const char* name;
    const char* pointer;
};

// clang-format off
inline const std::vector<Run> kRuns = {
    {"tank",       "paper",    {"trajectory"}},
    {"tank",       "standard", {"trajectory", "surface", "speed"}},
    {"euroc_mh01", "standard", {"trajectory", "speed"}},
    {"barge",      "standard", {"trajectory", "surface"}},
};

inline const std::vector<Goal> kGoals = {
    {"tank",       "paper",    "trajectory", "ate_rmse_m",            true,  0.020},
    {"tank",       "paper",    "trajectory", "scale_error",           true,  0.010},
    {"tank",       "standard", "trajectory", "ate_rmse_m",            true,  0.006},
    {"euroc_mh01", "standard", "trajectory", "ate_rmse_m",            true,  0.008},
    {"euroc_mh01", "standard", "trajectory", "coverage",              false, 1.0},
    {"barge",      "standard", "trajectory", "ate_rmse_m",            true,  0.060},
    {"barge",      "standard", "trajectory", "coverage",              false, 0.99},
    {"barge",      "standard", "surface",    "accuracy_median_m",     true,  0.020},
    {"tank",       "standard", "speed",      "frames_per_s",          false, 10.0},
};

inline constexpr Figure kFigures[] = {
    {"num_frames",               "/frames/num_frames"},
    {"coverage",                 "/frames/coverage"},
    {"path_length_m",            "/trajectory/final/path_length_m"},
    {"ate_rmse_m",               "/trajectory/final/ate_rmse_m"},
    {"ate_max_m",                "/trajectory/final/ate_max_m"},
    {"sim3_scale",               "/trajectory/final/sim3_scale"},
    {"drift_percent",            "/trajectory/final/drift_percent"},
    {"end_drift_percent",        "/trajectory/final/end_drift_percent"},
    {"causal_ate_rmse_m",        "/trajectory/causal/ate_rmse_m"},
    {"num_distances_measured",   "/known_distances/num_measured"},
    {"scale_error",              "/known_distances/scale_error"},
    {"distance_median_error_m",  "/known_distances/median_abs_error_m"},
    {"accuracy_median_m",        "/surface/accuracy/median_m"},
    {"accuracy_rms_m",           "/surface/accuracy/rms_m"},
    {"completeness_median_m",    "/surface/completeness/median_m"},
    {"f1_5mm",                   "/surface/scores/0/f1"},
    {"f1_10mm",                  "/surface/scores/1/f1"},
    {"f1_20mm",                  "/surface/scores/2/f1"},
    {"f1_50mm",                  "/surface/scores/3/f1"},
    {"mesh_area_m2",             "/mesh/area_m2"},
    {"num_triangles",            "/mesh/num_triangles"},
    {"frames_per_s",             "/speed/frames_per_s"},
    {"cpu_s",                    "/speed/cpu_s"},
    {"wall_s",                   "/speed/wall_s"},
    {"peak_memory_bytes",        "/speed/peak_memory_bytes"},
};
// clang-format on

}  // namespace divemesh::bench
