#include "worker/reef/figure_doubts.hpp"

#include <algorithm>
#include <cmath>

#include "worker/reef/move_steps.hpp"

namespace divemesh::worker {
namespace {

std::vector<double> values_of(const std::vector<FigureKind>& kinds,
                              const Ground& ground,
                              const std::vector<Simulated>& simulated) {
    std::vector<double> values;
    for (std::size_t k = 0; k < kinds.size(); ++k)
        values.push_back(value_of(kinds[k], ground, simulated[k].measured));
    return values;
}

double difference(double value, const Simulated& simulated) {
    return std::isfinite(value) ? std::abs(value - simulated.measured) : 0.0;
}

std::vector<double> of_hidden_ground(const OutlineSurvey& survey,
                                     const std::vector<FigureKind>& kinds,
                                     const std::vector<Simulated>& simulated) {
    std::vector<double> doubts(kinds.size(), 0.0);
    if (!survey.has_hidden) return doubts;
    const Ground low = survey.ground(survey.patch[0].vertices, 0, bridged_low);
    const std::vector<double> values = values_of(kinds, low, simulated);
    for (std::size_t k = 0; k < kinds.size(); ++k) doubts[k] = difference(values[k], simulated[k]);
    return doubts;
}

std::vector<double> of_steps(const OutlineSurvey& survey,
                             const std::vector<FigureKind>& kinds,
                             const std::vector<Simulated>& simulated) {
    std::vector<double> doubts(kinds.size(), 0.0);
    const double deviation_m = survey.fineness.detail_m.value_or(0.0) / std::sqrt(12.0);
    const Ground measured = survey.ground(survey.patch[0].vertices);
    for (const double outwards_m : {deviation_m, -deviation_m}) {
        Ground ground = measured;
        ground.bridged = with_steps_moved(measured.bridged, outwards_m);
        const std::vector<double> moved = values_of(kinds, ground, simulated);
        for (std::size_t k = 0; k < kinds.size(); ++k)
            if (!kinds[k].loses_detail)
                doubts[k] = std::max(doubts[k], difference(moved[k], simulated[k]));
    }
    return doubts;
}

}  // namespace

double value_of(const FigureKind& kind, const Ground& ground, double near) {
    const double value = kind.measure(ground).value_or(std::nan(""));
    if (!kind.is_direction || std::isnan(near)) return value;
    return value + 360.0 * std::round((near - value) / 360.0);
}

std::vector<double> figure_doubts(const OutlineSurvey& survey,
                                  const std::vector<FigureKind>& kinds,
                                  const std::vector<Simulated>& simulated,
                                  const MeasureOptions& options) {
    std::vector<double> doubts = of_steps(survey, kinds, simulated);
    const std::vector<double> hidden = of_hidden_ground(survey, kinds, simulated);
    const std::vector<double> bends =
        bend_deviations(survey.patch,
                        survey.fineness.detail_m.value_or(survey.fineness.correlation_length_m),
                        options,
                        [&](const Places& places) {
                            return values_of(kinds, survey.ground(places[0]), simulated);
                        });
    for (std::size_t k = 0; k < kinds.size(); ++k)
        doubts[k] = std::hypot(doubts[k], hidden[k], bends.empty() ? 0.0 : bends[k]);
    return doubts;
}

}  // namespace divemesh::worker
