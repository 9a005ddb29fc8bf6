#include "worker/reef/systematic_uncertainty.hpp"

#include <algorithm>
#include <cmath>

#include "worker/base/parallel.hpp"
#include "worker/reef/dilate_steps.hpp"
#include "worker/reef/displace_steps.hpp"

namespace divemesh::reef {
namespace {

std::vector<double> values_of(const std::vector<MetricKind>& kinds,
                              const Ground& ground,
                              const std::vector<stats::Simulated>& simulated) {
    std::vector<double> values;
    for (std::size_t k = 0; k < kinds.size(); ++k)
        values.push_back(value_of(kinds[k], ground, simulated[k].measured));
    return values;
}

double difference(double value, const stats::Simulated& simulated) {
    return std::isfinite(value) ? std::abs(value - simulated.measured) : 0.0;
}

std::vector<double> of_hidden_ground(const OutlineSurvey& survey,
                                     const std::vector<MetricKind>& kinds,
                                     const std::vector<stats::Simulated>& simulated) {
    std::vector<double> systematic(kinds.size(), 0.0);
    if (!survey.has_hidden) return systematic;
    const Ground low = survey.ground(survey.patch[0].vertices, 0, gaps_filled_low);
    const std::vector<double> values = values_of(kinds, low, simulated);
    const Ground measured = survey.ground(survey.patch[0].vertices);
    for (std::size_t k = 0; k < kinds.size(); ++k) {
        systematic[k] = difference(values[k], simulated[k]);
        if (kinds[k].hidden_deviation)
            systematic[k] = std::hypot(systematic[k], kinds[k].hidden_deviation(measured));
    }
    return systematic;
}

// Returns one standard deviation of where a step lies: anywhere in the support of a disparity,
// which is twice as wide where only the half size of the images was matched.
double step_deviation_m(const OutlineSurvey& survey) {
    return 2.0 * survey.sampling_resolution.detail_m.value_or(0.0) / std::sqrt(12.0);
}

// Steps that lie all farther out or in.
std::vector<double> of_dilated_steps(const OutlineSurvey& survey,
                                     const std::vector<MetricKind>& kinds,
                                     const std::vector<stats::Simulated>& simulated) {
    std::vector<double> systematic(kinds.size(), 0.0);
    const double deviation_m = step_deviation_m(survey);
    const Ground measured = survey.ground(survey.patch[0].vertices);
    for (const double outwards_m : {deviation_m, -deviation_m}) {
        Ground ground = measured;
        ground.gaps_filled = with_steps_dilated(measured.gaps_filled, outwards_m);
        const std::vector<double> moved = values_of(kinds, ground, simulated);
        for (std::size_t k = 0; k < kinds.size(); ++k)
            if (!kinds[k].loses_detail)
                systematic[k] = std::max(systematic[k], difference(moved[k], simulated[k]));
    }
    return systematic;
}

// Steps that each lie beside their place.
std::vector<double> of_displaced_steps(const OutlineSurvey& survey,
                                       const std::vector<MetricKind>& kinds,
                                       const std::vector<stats::Simulated>& simulated,
                                       const MeasureOptions& options) {
    constexpr std::size_t kNumReplicates = 32;
    StepDisplacement displacement{
        step_deviation_m(survey), survey.sampling_resolution.detail_m.value_or(0.0), 0};
    if (displacement.deviation_m < survey.shape.spacing_m) return {};
    const Ground measured = survey.ground(survey.patch[0].vertices);
    std::vector<std::vector<double>> values(kNumReplicates);
    base::for_each_index(options.num_threads, values.size(), [&](std::size_t i) {
        StepDisplacement of_replicate = displacement;
        of_replicate.seed = options.seed + i;
        Ground ground = measured;
        ground.grid = with_steps_displaced(measured.grid, of_replicate);
        ground.gaps_filled = with_steps_displaced(measured.gaps_filled, of_replicate);
        values[i] = values_of(kinds, ground, simulated);
    });
    return standard_deviations(values);
}

}  // namespace

double value_of(const MetricKind& kind, const Ground& ground, double near) {
    const double value = kind.measure(ground).value_or(std::nan(""));
    if (!kind.is_direction || std::isnan(near)) return value;
    return value + 360.0 * std::round((near - value) / 360.0);
}

std::vector<double> systematic_uncertainty(const OutlineSurvey& survey,
                                           const std::vector<MetricKind>& kinds,
                                           const std::vector<stats::Simulated>& simulated,
                                           const MeasureOptions& options) {
    std::vector<double> systematic = of_dilated_steps(survey, kinds, simulated);
    const std::vector<double> displaced = of_displaced_steps(survey, kinds, simulated, options);
    const std::vector<double> hidden = of_hidden_ground(survey, kinds, simulated);
    const std::vector<double> bends =
        bend_deviations(survey.patch,
                        survey.sampling_resolution.detail_m.value_or(
                            survey.sampling_resolution.correlation_length_m),
                        options,
                        [&](const Places& places) {
                            return values_of(kinds, survey.ground(places[0]), simulated);
                        });
    for (std::size_t k = 0; k < kinds.size(); ++k)
        systematic[k] = std::hypot(std::hypot(systematic[k], hidden[k]),
                                   displaced.empty() ? 0.0 : displaced[k],
                                   bends.empty() ? 0.0 : bends[k]);
    return systematic;
}

}  // namespace divemesh::reef
