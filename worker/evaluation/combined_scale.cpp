#include "worker/evaluation/combined_scale.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace divemesh::evaluation {
namespace {

constexpr double kMaxCorrection = 0.1;  // beyond it a size was stated wrong

double information(const ScaleCheck& check) { return 1.0 / (check.sigma * check.sigma); }

ScaleCheck mean_of(const std::vector<ScaleSource>& sources) {
    double weight = 0.0;
    double weighted = 0.0;
    for (const ScaleSource& source : sources) {
        weight += information(source.check);
        weighted += information(source.check) * source.check.scale;
    }
    const double mean = weighted / weight;
    double chi2 = 0.0;
    for (const ScaleSource& source : sources)
        chi2 += information(source.check) * std::pow(source.check.scale - mean, 2);
    const double ratio =
        sources.size() > 1 ? std::sqrt(chi2 / static_cast<double>(sources.size() - 1)) : 1.0;
    return {mean, std::max(1.0, ratio) / std::sqrt(weight)};
}

}  // namespace

CombinedScale combined_scale(std::vector<ScaleSource> sources, double cameras_sigma) {
    CombinedScale result;
    result.sensors = mean_of(sources);
    result.sources = std::move(sources);
    result.differs = is_contradicted(result.sensors);
    const double with_cameras = std::hypot(result.sensors.sigma, cameras_sigma);
    result.refuted = is_contradicted({result.sensors.scale, with_cameras});
    if (result.refuted) {
        result.factor = result.sensors.scale;
        result.sigma = result.sensors.sigma;
        return result;
    }
    const double by_sensors = information(result.sensors);
    const double by_cameras = information({1.0, cameras_sigma});
    result.factor = (by_sensors * result.sensors.scale + by_cameras) / (by_sensors + by_cameras);
    result.sigma = 1.0 / std::sqrt(by_sensors + by_cameras);
    return result;
}

std::optional<CombinedScale> scale_correction(const std::vector<ScaleSource>& sources,
                                              double cameras_sigma) {
    if (sources.empty() || cameras_sigma <= 0.0) return std::nullopt;
    const CombinedScale scale = combined_scale(sources, cameras_sigma);
    if (!scale.differs || std::abs(scale.factor - 1.0) > kMaxCorrection) return std::nullopt;
    return scale;
}

nlohmann::json to_metrics(const CombinedScale& scale) {
    nlohmann::json sources = nlohmann::json::object();
    for (const ScaleSource& source : scale.sources) sources[source.name] = to_metrics(source.check);
    return {{"factor", scale.factor}, {"sigma", scale.sigma}, {"sources", std::move(sources)}};
}

}  // namespace divemesh::evaluation
