#include "worker/evaluation/combined_scale.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace divemesh::evaluation {
namespace {

constexpr double kMaxSigmaRatio = 0.75;  // of the cameras' sigma
// Of sensors that do not contradict the cameras: a calibration that nothing refutes is right to
// about a percent, even if this dive's images cannot tell that it still holds.
constexpr double kMaxSensorSigma = 0.01;
constexpr double kMaxCorrection = 0.1;  // beyond it a size was stated wrong

double information(const ScaleCheck& check) { return 1.0 / (check.sigma * check.sigma); }

ScaleCheck mean_of(const std::vector<ScaleSource>& sources) {
    std::vector<ScaleCheck> checks;
    checks.reserve(sources.size());
    for (const ScaleSource& source : sources) checks.push_back(source.check);
    return weighted_mean(checks);
}

}  // namespace

CombinedScale combined_scale(std::vector<ScaleSource> sources, double cameras_sigma) {
    CombinedScale result;
    result.sensors = mean_of(sources);
    result.sources = std::move(sources);
    result.differs = is_contradicted(result.sensors);
    result.is_better =
        result.sensors.sigma <= std::min(kMaxSensorSigma, kMaxSigmaRatio * cameras_sigma);
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
    CombinedScale scale = combined_scale(sources, cameras_sigma);
    if (!scale.differs && !scale.is_better) return std::nullopt;
    if (std::abs(scale.factor - 1.0) > kMaxCorrection) return std::nullopt;
    return scale;
}

nlohmann::json to_metrics(const CombinedScale& scale) {
    nlohmann::json sources = nlohmann::json::object();
    for (const ScaleSource& source : scale.sources) sources[source.name] = to_metrics(source.check);
    return {{"factor", scale.factor}, {"sigma", scale.sigma}, {"sources", std::move(sources)}};
}

}  // namespace divemesh::evaluation
