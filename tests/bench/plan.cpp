#include "tests/bench/plan.hpp"

#include <algorithm>

namespace divemesh::bench {
namespace {

constexpr int kNumSeeds = 5;

// Returns the names of the simulated dives of a scene; "": of all.
std::vector<std::string> simulated_names(const std::string& scene) {
    std::vector<std::string> names;
    for (const Dive& dive : all_dives())
        if (dive.simulated && (scene.empty() || dive.simulated->scene == scene))
            names.push_back(dive.name);
    return names;
}

std::vector<Run> trajectory_runs() {
    std::vector<Run> runs;
    for (const Dive& dive : all_dives())
        for (const std::string& preset : all_presets())
            for (const Ablation& ablation : all_ablations())
                if (preset == "standard" || ablation.name == "none")
                    runs.push_back({"trajectory", dive, preset, ablation});
    return runs;
}

}  // namespace

const std::vector<Dive>& all_dives() {
    static const std::vector<Dive> dives = [] {
        std::vector<Dive> list = {{"tank", {}}, {"euroc_mh01", {}}, {"barge", {}}};
        for (const char* scene : {"tank", "barge", "reef"})
            for (int seed = 1; seed <= kNumSeeds; ++seed)
                list.push_back({std::string("sim-") + scene + "-" + std::to_string(seed),
                                Dive::Simulated{scene, seed}});
        return list;
    }();
    return dives;
}

const std::vector<std::string>& all_presets() {
    static const std::vector<std::string> presets = {"paper", "fast", "standard", "accurate"};
    return presets;
}

const std::vector<Ablation>& all_ablations() {
    static const std::vector<Ablation> ablations = {
        {"none", nlohmann::json::object()},
        {"imu_off", {{"use_imu", false}}},
        {"ahrs_off", {{"use_ahrs", false}}},
        {"window_off", {{"estimator", "pairwise"}}},
        {"loops_off", {{"close_loops", false}}},
        {"hindsight_off", {{"close_loops", false}, {"adjust_whole_dive", false}}}};
    return ablations;
}

std::vector<Run> runs_of(const std::string& group) {
    const Ablation none = all_ablations().front();
    if (group == "trajectory") return trajectory_runs();
    std::vector<Run> runs;
    for (const Dive& dive : all_dives())
        for (const std::string& preset : all_presets())
            if (!dive.simulated || (group == "surface" && preset == "standard"))
                runs.push_back({group, dive, preset, none});
    return runs;
}

const std::vector<Goal>& all_goals() {
    using Over = Goal::Over;
    static const std::vector<std::string> simulated = simulated_names("");
    static const std::vector<std::string> reefs = simulated_names("reef");
    // clang-format off
    static const std::vector<Goal> goals = {
        {"trajectory", {"tank"},       "paper",    "ate_rmse_m",          Over::Worst,  true,  0.020},
        {"trajectory", {"tank"},       "paper",    "scale_error",         Over::Worst,  true,  0.010},
        {"trajectory", {"tank"},       "standard", "ate_rmse_m",          Over::Worst,  true,  0.0012},
        {"trajectory", {"euroc_mh01"}, "standard", "ate_rmse_m",          Over::Worst,  true,  0.004},
        {"trajectory", {"euroc_mh01"}, "standard", "causal_ate_rmse_m",   Over::Worst,  true,  0.008},
        {"trajectory", {"euroc_mh01"}, "standard", "coverage",            Over::Worst,  false, 1.0},
        {"trajectory", {"barge"},      "standard", "ate_rmse_m",          Over::Worst,  true,  0.010},
        {"trajectory", {"barge"},      "standard", "causal_ate_rmse_m",   Over::Worst,  true,  0.030},
        {"trajectory", {"barge"},      "standard", "revisit_rmse_m",      Over::Worst,  true,  0.015},
        {"trajectory", {"barge"},      "standard", "coverage",            Over::Worst,  false, 0.995},
        {"trajectory", simulated,      "standard", "ate_percent_of_path", Over::Median, true,  0.1},
        {"trajectory", simulated,      "standard", "ate_percent_of_path", Over::Worst,  true,  0.3},
        {"trajectory", simulated,      "standard", "coverage",            Over::Worst,  false, 0.99},
        {"trajectory", simulated,      "standard", "share_in_ellipsoid",  Over::Mean,   false, 0.80},
        {"trajectory", simulated,      "standard", "share_in_ellipsoid",  Over::Mean,   true,  0.99},
        {"trajectory", {"tank"},       "standard", "cpu_ms_per_frame",    Over::Worst,  true,  12.0},
        {"trajectory", {"barge"},      "standard", "cpu_ms_per_frame",    Over::Worst,  true,  12.0},
        {"trajectory", {"barge"},      "standard", "cpu_to_klt",          Over::Worst,  true,  1.3},
        {"surface",    {"barge"},      "standard", "accuracy_median_m",   Over::Worst,  true,  0.0035},
        {"surface",    {"barge"},      "standard", "f1_10mm",             Over::Worst,  false, 0.68},
        {"surface",    {"barge"},      "standard", "share_20mm",          Over::Worst,  false, 0.85},
        {"surface",    {"barge"},      "standard", "near_median_m",       Over::Worst,  true,  0.003},
        {"surface",    {"tank"},       "standard", "accuracy_median_m",   Over::Worst,  true,  0.003},
        {"surface",    {"tank"},       "standard", "f1_10mm",             Over::Worst,  false, 0.84},
        {"surface",    {"tank"},       "standard", "share_20mm",          Over::Worst,  false, 0.92},
        {"surface",    {"tank"},       "standard", "relative_median_percent", Over::Worst, true, 0.2},
        {"surface",    {"tank"},       "standard", "relative_p80_percent", Over::Worst, true,  0.5},
        {"surface",    {"tank"},       "standard", "scale_error",         Over::Worst,  true,  0.003},
        {"surface",    {"tank"},       "standard", "distance_max_error_m", Over::Worst, true,  0.003},
        {"surface",    reefs,          "standard", "share_20mm",          Over::Worst,  false, 0.85},
        {"surface",    simulated,      "standard", "false_share_50mm",    Over::Worst,  true,  0.015},
        {"surface",    {"middlebury"}, "standard", "bad2_to_opencv",      Over::Worst,  true,  1.0},
        {"speed",      {"tank"},       "standard", "frames_per_s",        Over::Worst,  false, 10.0},
        {"speed",      {"barge"},      "standard", "wall_to_sgbm",        Over::Worst,  true,  0.75},
        {"speed",      {"barge"},      "fast",     "wall_to_sgbm",        Over::Worst,  true,  0.45},
    };
    // clang-format on
    return goals;
}

const std::vector<Metric>& all_metrics() {
    // clang-format off
    static const std::vector<Metric> metrics = {
        {"num_frames",               "/frames/num_frames"},
        {"coverage",                 "/frames/coverage"},
        {"mean_tracked_features",    "/tracking/mean_tracked_features"},
        {"median_track_life_frames", "/tracking/median_track_life_frames"},
        {"inlier_share",             "/tracking/inlier_share"},
        {"path_length_m",            "/trajectory/final/path_length_m"},
        {"ate_rmse_m",               "/trajectory/final/ate_rmse_m"},
        {"ate_max_m",                "/trajectory/final/ate_max_m"},
        {"rotation_rmse_deg",        "/trajectory/final/rotation_rmse_deg"},
        {"sim3_scale",               "/trajectory/final/sim3_scale"},
        {"drift_percent",            "/trajectory/final/drift_percent"},
        {"end_drift_percent",        "/trajectory/final/end_drift_percent"},
        {"revisit_rmse_m",           "/trajectory/final/revisit/translation_rmse_m"},
        {"num_loops",                "/loops/num_accepted"},
        {"share_in_ellipsoid",       "/trajectory/covariance/check/share_in_95"},
        {"mean_nees",                "/trajectory/covariance/check/mean_nees"},
        {"causal_ate_rmse_m",        "/trajectory/causal/ate_rmse_m"},
        {"causal_drift_percent",     "/trajectory/causal/drift_percent"},
        {"num_distances_measured",   "/known_distances/num_measured"},
        {"scale_error",              "/known_distances/scale_error"},
        {"distance_median_error_m",  "/known_distances/median_abs_error_m"},
        {"distance_max_error_m",     "/known_distances/max_abs_error_m"},
        {"accuracy_median_m",        "/surface/accuracy/median_m"},
        {"accuracy_rms_m",           "/surface/accuracy/rms_m"},
        {"completeness_median_m",    "/surface/completeness/median_m"},
        {"near_median_m",            "/surface/near_completeness/median_m"},
        {"relative_median_percent",  "/surface/relative_accuracy/median_percent"},
        {"relative_p80_percent",     "/surface/relative_accuracy/p80_percent"},
        {"f1_5mm",                   "/surface/scores/0/f1"},
        {"f1_10mm",                  "/surface/scores/1/f1"},
        {"f1_20mm",                  "/surface/scores/2/f1"},
        {"f1_50mm",                  "/surface/scores/3/f1"},
        {"share_20mm",               "/surface/share_20mm"},
        {"false_share_50mm",         "/surface/false_share_50mm"},
        {"mesh_covered_share",       "/mesh/covered_share"},
        {"mesh_covered_of_matched",  "/mesh/covered_share_of_matched"},
        {"mesh_area_m2",             "/mesh/area_m2"},
        {"num_triangles",            "/mesh/num_triangles"},
        {"frames_per_s",             "/speed/frames_per_s"},
        {"cpu_s",                    "/speed/cpu_s"},
        {"wall_s",                   "/speed/wall_s"},
        {"peak_memory_bytes",        "/speed/peak_memory_bytes"},
    };
    // clang-format on
    return metrics;
}

}  // namespace divemesh::bench
