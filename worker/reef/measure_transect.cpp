#include <algorithm>
#include <cmath>

#include "worker/reef/area_metrics.hpp"
#include "worker/reef/measure_outline.hpp"
#include "worker/reef/metric_json.hpp"
#include "worker/reef/noise_level.hpp"
#include "worker/reef/rugosity.hpp"
#include "worker/reef/simulate_metrics.hpp"
#include "worker/reef/transect_profile.hpp"

namespace divemesh::reef {
namespace {

constexpr double kMargin_m = 0.05;

// Returns the ratio at each spacing; NaN: shorter than a link.
std::vector<double> chain_metrics(const Profile& profile, const MeasureOptions& options) {
    std::vector<double> values;
    for (const double spacing_m : options.spacings_m)
        values.push_back(chain_rugosity(every(profile, spacing_m)).value_or(std::nan("")));
    return values;
}

// Treats hidden ground as areas do: bridged, and no less than the seen ground.
std::vector<double> with_hidden(const Profile& profile, const MeasureOptions& options) {
    std::vector<double> values = chain_metrics(gaps_filled(profile), options);
    const std::vector<double> seen = chain_metrics(profile, options);
    for (std::size_t k = 0; k < values.size(); ++k) values[k] = std::fmax(values[k], seen[k]);
    return values;
}

MetricKind chain_kind(double spacing_m) {
    MetricKind kind{"chain_rugosity", "", spacing_m};
    kind.method =
        "chain with links of the resolution over the line, both seen from above "
        "(Risk 1972)";
    kind.lowest = 1.0;
    return kind;
}

// Returns the coarsest resolution of the segments, which holds for the whole line.
SamplingResolution sampling_resolution_of_all(const std::vector<TransectSegment>& segments,
                                              const std::vector<SurfacePatch>& patches,
                                              const MeasureOptions& options) {
    SamplingResolution all;
    for (std::size_t i = 0; i < segments.size(); ++i) {
        std::vector<Eigen::Vector3d> cameras;
        for (const Eigen::Vector3d& position : options.camera_positions_world)
            cameras.push_back(segments[i].plane.T_plane_world * position);
        const SamplingResolution here = sampling_resolution_of(patches[i], cameras, options);
        if (here.sigma_m) all.sigma_m = std::max(all.sigma_m.value_or(0.0), *here.sigma_m);
        if (here.sigma_local_m)
            all.sigma_local_m = std::max(all.sigma_local_m.value_or(0.0), *here.sigma_local_m);
        if (here.detail_m) all.detail_m = std::max(all.detail_m.value_or(0.0), *here.detail_m);
        all.correlation_length_m = std::max(all.correlation_length_m, here.correlation_length_m);
    }
    return all;
}

void limit_to_noise_level(const std::vector<TransectSegment>& segments,
                          std::vector<SurfacePatch>& patches,
                          double max_share,
                          SamplingResolution& sampling_resolution) {
    NoiseLevel noise(sampling_resolution.correlation_length_m);
    for (std::size_t i = 0; i < segments.size(); ++i) noise.add(patches[i], segments[i].shape);
    const double share = std::min(max_share, noise.share());
    if (sampling_resolution.sigma_local_m) *sampling_resolution.sigma_local_m *= share;
    for (SurfacePatch& patch : patches)
        for (double& sigma : patch.sigma_local_m) sigma *= share;
}

nlohmann::json described(const AreaTask& task,
                         double length_m,
                         double coverage,
                         const SamplingResolution& resolution) {
    nlohmann::json area = {{"name", task.name},
                           {"kind", task.kind},
                           {"length_m", length_m},
                           {"coverage", coverage},
                           {"correlation_length_m", resolution.correlation_length_m}};
    if (!task.label.empty()) area["label"] = task.label;
    if (resolution.sigma_m) area["sigma_m"] = *resolution.sigma_m;
    if (resolution.sigma_local_m) area["sigma_local_m"] = *resolution.sigma_local_m;
    if (resolution.detail_m) area["detail_m"] = *resolution.detail_m;
    return area;
}

}  // namespace

AreaResult measure_transect(const types::Mesh& mesh,
                            const AreaTask& task,
                            const std::vector<Eigen::Vector3d>& line,
                            const Eigen::Vector3d& normal,
                            const MeasureOptions& options) {
    const std::vector<TransectSegment> segments = segments_of(line, normal);
    std::vector<SurfacePatch> patches;
    double length = 0.0;
    for (const TransectSegment& segment : segments) {
        patches.push_back(cut_patch(mesh, segment.plane, kMargin_m));
        fill_in_sigma(patches.back(), options);
        length += segment.plane.outline[1].x() - segment.plane.outline[0].x();
    }
    Places measured;
    for (const SurfacePatch& patch : patches) measured.push_back(patch.vertices);
    AreaResult result;
    result.coverage = coverage_of(profile_of(segments, patches, measured));
    SamplingResolution sampling_resolution = sampling_resolution_of_all(segments, patches, options);
    limit_to_noise_level(segments, patches, options.noise_share, sampling_resolution);
    result.area = described(task, length, result.coverage, sampling_resolution);
    const Evaluate evaluate = [&](const Places& places, int num_blurs) {
        Profile profile = profile_of(segments, patches, places);
        for (int i = 0; i < num_blurs; ++i)
            profile = blurred(profile, *sampling_resolution.detail_m);
        return with_hidden(profile, options);
    };
    const std::vector<stats::Simulated> simulated =
        simulate_metrics(patches,
                         sampling_resolution.correlation_length_m,
                         sampling_resolution.detail_m.has_value(),
                         options,
                         evaluate);
    const std::vector<double> bends = bend_deviations(
        patches,
        sampling_resolution.detail_m.value_or(sampling_resolution.correlation_length_m),
        options,
        [&](const Places& places) { return evaluate(places, 0); });
    const std::vector<double> seen =
        chain_metrics(profile_of(segments, patches, measured), options);
    for (std::size_t k = 0; k < options.spacings_m.size(); ++k) {
        const MetricKind kind = chain_kind(options.spacings_m[k]);
        const double hidden = std::isfinite(seen[k]) ? simulated[k].measured - seen[k] : 0.0;
        const stats::Estimate estimated = stats::estimate(
            simulated[k],
            options.sigma_relative_error,
            {.relative = 0.0, .absolute = std::hypot(hidden, bends.empty() ? 0.0 : bends[k])});
        const auto refused = refused_at(options.spacings_m[k], sampling_resolution);
        if (result.coverage < options.min_coverage)
            result.metrics.push_back(
                refused_json(task, kind, "less than half of the line was seen"));
        else if (refused)
            result.metrics.push_back(refused_json(task, kind, *refused));
        else if (!std::isfinite(estimated.low))
            result.metrics.push_back(refused_json(task, kind, "the line is shorter than a link"));
        else
            result.metrics.push_back(metric_json(task, kind, estimated));
    }
    return result;
}

}  // namespace divemesh::reef
