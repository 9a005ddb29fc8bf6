#include "worker/reef/measure_outline.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "worker/base/text.hpp"
#include "worker/reef/fractal_dimension.hpp"
#include "worker/reef/metric_json.hpp"
#include "worker/reef/outline_survey.hpp"
#include "worker/reef/simulate_metrics.hpp"
#include "worker/reef/systematic_uncertainty.hpp"

namespace divemesh::reef {
namespace {

// Returns sigma of an area whose border is known to half the detail of the surface, each such
// length of it independently.
double border_sigma_m2(double border_m, double detail_m) {
    return detail_m * std::sqrt(border_m * detail_m / 12.0);
}

std::vector<stats::Simulated> simulate(const OutlineSurvey& survey,
                                       const std::vector<MetricKind>& kinds,
                                       const MeasureOptions& options) {
    std::vector<double> measured(kinds.size(), std::nan(""));
    const Evaluate evaluate = [&](const Places& places, int num_blurs) {
        const Ground ground = survey.ground(places[0], num_blurs);
        std::vector<double> values;
        for (std::size_t k = 0; k < kinds.size(); ++k)
            values.push_back(num_blurs > 0 && !kinds[k].loses_detail
                                 ? std::nan("")
                                 : value_of(kinds[k], ground, measured[k]));
        return values;
    };
    measured = evaluate({survey.patch[0].vertices}, 0);
    return simulate_metrics(survey.patch,
                            survey.sampling_resolution.correlation_length_m,
                            survey.sampling_resolution.detail_m.has_value(),
                            options,
                            evaluate);
}

std::optional<std::string> refusal(const MetricKind& kind,
                                   const AreaTask& task,
                                   const SamplingResolution& sampling_resolution,
                                   double coverage,
                                   const MeasureOptions& options) {
    if (task.is_whole_model && kind.metric == "volume")
        return "the whole model has no reference plane: give an area";
    const double min_coverage =
        kind.is_extreme ? options.min_coverage_of_extremes : options.min_coverage;
    if (!task.is_whole_model && coverage < min_coverage)
        return std::to_string(std::lround(100.0 * coverage)) +
               " % of the area was seen, less than " +
               std::to_string(std::lround(100.0 * min_coverage)) + " %";
    return kind.resolution_m ? refused_at(*kind.resolution_m, sampling_resolution) : std::nullopt;
}

// Returns a refusal if heights within a square of the metric's resolution differ by less than three
// sigma of the surface: a fractal dimension of less would be that of errors, about 2.5.
std::optional<std::string> too_flat(const MetricKind& kind, const OutlineSurvey& survey) {
    if (!kind.needs_height_spread || !kind.resolution_m) return std::nullopt;
    const std::vector<double> ranges =
        height_ranges(survey.grid(survey.patch[0].vertices), *kind.resolution_m);
    if (ranges.empty()) return std::nullopt;
    const double mean =
        std::accumulate(ranges.begin(), ranges.end(), 0.0) / static_cast<double>(ranges.size());
    const double min_difference_m = 3.0 * survey.sampling_resolution.sigma_m.value_or(0.0);
    if (mean > min_difference_m) return std::nullopt;
    return "too flat: heights within " + length_text(*kind.resolution_m) + " differ by " +
           length_text(mean) + ", not more than 3 sigma of the surface, " +
           length_text(min_difference_m);
}

stats::SharedError shared_error(const MetricKind& kind,
                                const AreaResult& result,
                                const MeasureOptions& options) {
    return {std::abs(kind.length_power) * options.scale_sigma,
            kind.is_from_plane ? options.sigma_shared_m * result.coverage * result.planar_m2 : 0.0};
}

// Returns the kind with the share of the area that was seen, if the rest counts too.
MetricKind with_share_seen(MetricKind kind, const OutlineSurvey& survey, double coverage) {
    if (survey.has_hidden && kind.hidden_deviation)
        kind.method += "; " + base::fixed(100.0 * coverage, 1) +
                       " % of the area was seen, the rest counts as at least as rough";
    return kind;
}

// Adds the metrics; those that cannot be measured with the reason, in their place.
void add_metrics(const std::vector<MetricKind>& kinds,
                 const AreaTask& task,
                 const OutlineSurvey& survey,
                 const MeasureOptions& options,
                 AreaResult& result) {
    std::vector<std::optional<std::string>> refused;
    std::vector<MetricKind> taken;
    for (const MetricKind& kind : kinds) {
        refused.push_back(
            refusal(kind, task, survey.sampling_resolution, result.coverage, options));
        if (!refused.back()) refused.back() = too_flat(kind, survey);
        if (!refused.back()) taken.push_back(kind);
    }
    const std::vector<stats::Simulated> simulated = simulate(survey, taken, options);
    const std::vector<double> systematic =
        systematic_uncertainty(survey, taken, simulated, options);
    std::size_t next = 0;
    for (std::size_t k = 0; k < kinds.size(); ++k) {
        if (refused[k]) {
            result.metrics.push_back(refused_json(task, kinds[k], *refused[k]));
            continue;
        }
        stats::SharedError shared = shared_error(kinds[k], result, options);
        shared.absolute = std::hypot(shared.absolute, systematic[next]);
        const stats::Estimate estimated =
            stats::estimate(simulated[next++], options.sigma_relative_error, shared);
        const bool is_known = std::isfinite(estimated.low) && std::isfinite(estimated.high);
        if (estimated.high < kinds[k].lowest || estimated.low > kinds[k].highest) {
            result.metrics.push_back(refused_json(
                task, kinds[k], "the whole interval is outside of the possible values"));
            continue;
        }
        const MetricKind kind = with_share_seen(kinds[k], survey, result.coverage);
        result.metrics.push_back(is_known ? metric_json(task, kind, estimated)
                                          : refused_json(task,
                                                         kinds[k],
                                                         kinds[k].is_direction
                                                             ? "too flat to have a direction"
                                                             : "too little ground was seen"));
    }
}

void add_given(const AreaTask& task,
               const AreaPlane& plane,
               const MeasureOptions& options,
               AreaResult& result) {
    const auto of_value = [&](double value, int length_power, double sigma) {
        return stats::estimate(
            {value, value, {}, {}}, 0.0, {length_power * options.scale_sigma, sigma});
    };
    MetricKind planar{"planar_area", "m2", std::nullopt};
    planar.method = task.is_whole_model ? "samples with surface, seen from above"
                                        : "of the outline as given, along its normal";
    result.metrics.push_back(
        metric_json(task, planar, of_value(result.planar_m2, 2, result.border_sigma_m2)));
    if (task.is_whole_model) return;
    const double longest = max_diameter_m(plane.outline);
    MetricKind diameter{"longest_diameter", "m", std::nullopt};
    diameter.method = "between the two farthest corners of the outline as given";
    result.metrics.push_back(metric_json(task, diameter, of_value(longest, 1, 0.0)));
}

nlohmann::json describe(const AreaTask& task,
                        const AreaResult& result,
                        const SamplingResolution& sampling_resolution) {
    nlohmann::json json = {{"name", task.name},
                           {"kind", task.kind},
                           {"coverage", result.coverage},
                           {"correlation_length_m", sampling_resolution.correlation_length_m}};
    if (!task.label.empty()) json["label"] = task.label;
    if (sampling_resolution.sigma_m) json["sigma_m"] = *sampling_resolution.sigma_m;
    if (sampling_resolution.sigma_local_m)
        json["sigma_local_m"] = *sampling_resolution.sigma_local_m;
    if (sampling_resolution.detail_m) json["detail_m"] = *sampling_resolution.detail_m;
    return json;
}

}  // namespace

AreaResult measure_outline(const types::Mesh& mesh,
                           const AreaTask& task,
                           const AreaPlane& plane,
                           const MeasureOptions& options) {
    AreaResult result;
    result.planar_m2 = area_m2(plane.outline);
    auto [survey, has_samples] = cut_outline(mesh, plane, options);
    if (has_samples) {
        result.noise_share = limit_to_noise_level(survey, options.noise_share);
        const SeenNodes seen = count_seen(survey);
        result.coverage = seen.num_within > 0.0 ? seen.num_seen / seen.num_within : 0.0;
        survey.has_hidden = !task.is_whole_model && result.coverage < 1.0;
        if (task.is_whole_model) {
            const double spacing_m = survey.shape.spacing_m;
            result.coverage = seen.num_seen > 0.0 ? 1.0 : 0.0;
            result.planar_m2 = seen.num_seen * spacing_m * spacing_m;
            result.border_sigma_m2 = border_sigma_m2(
                seen.num_border * spacing_m,
                std::max(spacing_m, survey.sampling_resolution.detail_m.value_or(0.0)));
        }
    }
    result.area = describe(task, result, survey.sampling_resolution);
    result.area["planar_area_m2"] = result.planar_m2;
    add_given(task, plane, options, result);
    const auto kinds = area_metrics(
        options, survey.sampling_resolution, finest_spacing_m(options, survey.sampling_resolution));
    if (has_samples && result.coverage > 0.0) {
        add_metrics(kinds, task, survey, options, result);
        return result;
    }
    for (const MetricKind& kind : kinds)
        result.metrics.push_back(refused_json(
            task,
            kind,
            has_samples ? "none of the area was seen" : "too large for samples of 25 cm"));
    return result;
}

}  // namespace divemesh::reef
