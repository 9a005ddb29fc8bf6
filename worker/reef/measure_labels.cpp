#include "worker/reef/measure_labels.hpp"

#include <algorithm>
#include <map>

#include "worker/reef/metric_json.hpp"
#include "worker/reef/population.hpp"

namespace divemesh::reef {
namespace {

bool is_on(const SurveyedGround& ground, const Area& colony) {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& point : colony.points)
        centre += point / static_cast<double>(colony.points.size());
    return ground.quadrats.empty() ||
           std::any_of(
               ground.quadrats.begin(), ground.quadrats.end(), [&](const AreaPlane& quadrat) {
                   return contains(quadrat.outline, (quadrat.T_plane_world * centre).head<2>());
               });
}

void add(const AreaTask& task,
         const std::string& metric,
         const std::string& unit,
         const std::string& method,
         const stats::Estimate& estimate,
         nlohmann::json& metrics) {
    MetricKind kind{metric, unit, std::nullopt, method};
    kind.lowest = 0.0;
    metrics.push_back(metric_json(task, kind, estimate));
}

void add_sizes(const AreaTask& task,
               const std::string& what,
               const std::string& unit,
               const std::vector<double>& sizes,
               std::uint64_t seed,
               nlohmann::json& metrics) {
    const std::string method = "over the colonies, bootstrap";
    add(task, what + "_q25", unit, method, size_quantile(sizes, 0.25, seed), metrics);
    add(task, what + "_median", unit, method, size_quantile(sizes, 0.5, seed), metrics);
    add(task, what + "_q75", unit, method, size_quantile(sizes, 0.75, seed), metrics);
}

}  // namespace

nlohmann::json measure_labels(const AreaSet& set,
                              const SurveyedGround& ground,
                              std::uint64_t seed) {
    std::map<std::string, Population> populations;
    for (const Area& area : set.areas) {
        if (area.label.empty() || area.kind == AreaKind::Transect || !is_on(ground, area)) continue;
        const AreaPlane plane = plane_of(area);
        Population& population = populations[area.label];
        population.surveyed_m2 = ground.seen_m2;
        population.areas_m2.push_back(area_m2(plane.outline));
        population.diameters_m.push_back(max_diameter_m(plane.outline));
    }
    nlohmann::json metrics = nlohmann::json::array();
    for (const auto& [label, population] : populations) {
        const AreaTask task{ground.name, label, ""};
        if (!(ground.seen_m2 > 0.0)) {
            metrics.push_back(refused_json(task,
                                           {"population_density", "1/m2", std::nullopt},
                                           "none of the surveyed ground was seen"));
            continue;
        }
        add(task,
            "population_density",
            "1/m2",
            "colonies over surveyed ground, Poisson",
            density_per_m2(population),
            metrics);
        add(task,
            "cover",
            "",
            "planar area of the colonies over surveyed ground, compound Poisson",
            cover(population),
            metrics);
        add_sizes(task, "colony_area", "m2", population.areas_m2, seed, metrics);
        add_sizes(task, "colony_diameter", "m", population.diameters_m, seed, metrics);
    }
    return metrics;
}

}  // namespace divemesh::reef
