#include "worker/reef/measure_labels.hpp"

#include <algorithm>
#include <map>
#include <utility>

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

struct Sizes {
    std::string what;
    std::string unit;
    const std::vector<double>& values;
    double relative_sigma = 0.0;  // that they share
};

void add_sizes(const AreaTask& task,
               const Sizes& sizes,
               std::uint64_t seed,
               nlohmann::json& metrics) {
    for (const auto& [ending, share] : {std::pair("_q25", 0.25), {"_median", 0.5}, {"_q75", 0.75}})
        add(task,
            sizes.what + ending,
            sizes.unit,
            "over the colonies, bootstrap",
            stats::with_shared_error(size_quantile(sizes.values, share, seed),
                                     sizes.relative_sigma),
            metrics);
}

}  // namespace

nlohmann::json measure_labels(const AreaSet& set,
                              const SurveyedGround& ground,
                              const MeasureOptions& options) {
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
            stats::with_shared_error(density_per_m2(population), 2.0 * options.scale_sigma),
            metrics);
        add(task,
            "cover",
            "",
            "planar area of the colonies over surveyed ground, compound Poisson",
            cover(population),
            metrics);
        add_sizes(task,
                  {"colony_area", "m2", population.areas_m2, 2.0 * options.scale_sigma},
                  options.seed,
                  metrics);
        add_sizes(task,
                  {"colony_diameter", "m", population.diameters_m, options.scale_sigma},
                  options.seed,
                  metrics);
    }
    return metrics;
}

}  // namespace divemesh::reef
