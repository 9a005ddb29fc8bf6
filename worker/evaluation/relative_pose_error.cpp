#include "worker/evaluation/relative_pose_error.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "worker/base/angle.hpp"
#include "worker/base/rotation_vector.hpp"
#include "worker/stats/median.hpp"
#include "worker/stats/summary.hpp"

namespace divemesh::evaluation {
namespace {

using IndexPairs = std::vector<std::pair<std::size_t, std::size_t>>;

double step_m(const std::vector<PosePair>& poses, std::size_t i) {
    return (poses[i].T_world_body.translation() - poses[i - 1].T_world_body.translation()).norm();
}

// As in evo, counting starts at the first pose, and the first pair begins where delta_m is reached.
IndexPairs consecutive_pairs(const std::vector<PosePair>& poses, double delta_m) {
    std::vector<std::size_t> ends;
    double path_m = 0.0;
    for (std::size_t i = 1; i < poses.size(); ++i) {
        path_m += step_m(poses, i);
        if (path_m < delta_m) continue;
        ends.push_back(i);
        path_m = 0.0;
    }
    IndexPairs pairs;
    for (std::size_t i = 1; i < ends.size(); ++i) pairs.emplace_back(ends[i - 1], ends[i]);
    return pairs;
}

IndexPairs all_pairs(const std::vector<PosePair>& poses, double delta_m) {
    constexpr double kTolerance = 0.1;  // of delta_m; evo's default
    std::vector<double> lengths(poses.size(), 0.0);
    for (std::size_t i = 1; i < poses.size(); ++i) lengths[i] = lengths[i - 1] + step_m(poses, i);
    IndexPairs pairs;
    for (std::size_t start = 0; start + 1 < poses.size(); ++start) {
        const double wanted = lengths[start] + delta_m;
        const auto first = lengths.begin() + static_cast<std::ptrdiff_t>(start) + 1;
        auto nearest = std::lower_bound(first, lengths.end(), wanted);
        if (nearest == lengths.end() ||
            (nearest != first && wanted - *std::prev(nearest) <= *nearest - wanted))
            nearest = std::lower_bound(first, lengths.end(), *std::prev(nearest));
        if (std::abs(*nearest - wanted) <= kTolerance * delta_m)
            pairs.emplace_back(start, static_cast<std::size_t>(nearest - lengths.begin()));
    }
    return pairs;
}

}  // namespace

RelativePoseError relative_pose_error(const std::vector<PosePair>& poses,
                                      const RelativePoseOptions& options) {
    const auto pairs = options.pairs == RelativePoseOptions::Pairs::Consecutive
                           ? consecutive_pairs(poses, options.delta_m)
                           : all_pairs(poses, options.delta_m);
    std::vector<double> translations_m;
    std::vector<double> angles_deg;
    for (const auto& [from, to] : pairs) {
        const Eigen::Isometry3d truth =
            poses[from].T_reference_body.inverse() * poses[to].T_reference_body;
        const Eigen::Isometry3d estimate =
            poses[from].T_world_body.inverse() * poses[to].T_world_body;
        const Eigen::Isometry3d error = truth.inverse() * estimate;
        translations_m.push_back(error.translation().norm());
        angles_deg.push_back(base::angle_rad(error.linear()) * base::kDegPerRad);
    }
    RelativePoseError result;
    result.delta_m = options.delta_m;
    result.num_pairs = static_cast<std::int64_t>(pairs.size());
    if (pairs.empty()) return result;
    result.translation_rmse_m = stats::root_mean_square(translations_m);
    result.translation_mean_m = stats::mean(translations_m);
    result.translation_median_m = stats::median(translations_m);
    result.translation_max_m = *std::max_element(translations_m.begin(), translations_m.end());
    result.rotation_rmse_deg = stats::root_mean_square(angles_deg);
    return result;
}

nlohmann::json to_metrics(const RelativePoseError& error) {
    nlohmann::json json = {{"delta_m", error.delta_m}, {"num_pairs", error.num_pairs}};
    if (error.num_pairs == 0) return json;
    json["translation_rmse_m"] = error.translation_rmse_m;
    json["translation_mean_m"] = error.translation_mean_m;
    json["translation_median_m"] = error.translation_median_m;
    json["translation_max_m"] = error.translation_max_m;
    json["rotation_rmse_deg"] = error.rotation_rmse_deg;
    return json;
}

}  // namespace divemesh::evaluation
