#include <algorithm>
#include <cmath>

#include "worker/reef/area_figures.hpp"
#include "worker/reef/figure_json.hpp"
#include "worker/reef/measure_outline.hpp"
#include "worker/reef/rugosity.hpp"
#include "worker/reef/shown_noise.hpp"
#include "worker/reef/simulate_figures.hpp"
#include "worker/reef/transect_profile.hpp"

namespace divemesh::worker {
namespace {

constexpr double kMargin_m = 0.05;

// At each spacing; NaN: shorter than a link.
std::vector<double> chain_figures(const Profile& profile, const MeasureOptions& options) {
    std::vector<double> values;
    for (const double spacing_m : options.spacings_m)
        values.push_back(chain_rugosity(every(profile, spacing_m)).value_or(std::nan("")));
    return values;
}

// As areas take hidden ground: bridged, and no less than what was seen.
std::vector<double> with_hidden(const Profile& profile, const MeasureOptions& options) {
    std::vector<double> values = chain_figures(bridged(profile), options);
    const std::vector<double> seen = chain_figures(profile, options);
    for (std::size_t k = 0; k < values.size(); ++k) values[k] = std::fmax(values[k], seen[k]);
    return values;
}

FigureKind chain_kind(double spacing_m) {
    FigureKind kind{"chain_rugosity", "", spacing_m};
    kind.method =
        "chain with links of the resolution over the line, both seen from above "
        "(Risk 1972)";
    kind.lowest = 1.0;
    return kind;
}

// The roughest of the pieces says what can be said of the whole line.
Fineness fineness_of_all(const std::vector<TransectPiece>& pieces,
                         const std::vector<SurfacePatch>& patches,
                         const MeasureOptions& options) {
    Fineness all;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        std::vector<Eigen::Vector3d> cameras;
        for (const Eigen::Vector3d& position : options.camera_positions_world)
            cameras.push_back(pieces[i].plane.T_plane_world * position);
        const Fineness here = fineness_of(patches[i], cameras, options);
        if (here.sigma_m) all.sigma_m = std::max(all.sigma_m.value_or(0.0), *here.sigma_m);
        if (here.sigma_local_m)
            all.sigma_local_m = std::max(all.sigma_local_m.value_or(0.0), *here.sigma_local_m);
        if (here.detail_m) all.detail_m = std::max(all.detail_m.value_or(0.0), *here.detail_m);
        all.correlation_length_m = std::max(all.correlation_length_m, here.correlation_length_m);
    }
    return all;
}

void keep_shown_noise(const std::vector<TransectPiece>& pieces,
                      std::vector<SurfacePatch>& patches,
                      double most,
                      Fineness& fineness) {
    ShownNoise noise(fineness.correlation_length_m);
    for (std::size_t i = 0; i < pieces.size(); ++i) noise.add(patches[i], pieces[i].shape);
    const double share = std::min(most, noise.share());
    if (fineness.sigma_local_m) *fineness.sigma_local_m *= share;
    for (SurfacePatch& patch : patches)
        for (double& sigma : patch.sigma_local_m) sigma *= share;
}

}  // namespace

AreaResult measure_transect(const Mesh& mesh,
                            const AreaTask& task,
                            const std::vector<Eigen::Vector3d>& line,
                            const Eigen::Vector3d& normal,
                            const MeasureOptions& options) {
    const std::vector<TransectPiece> pieces = pieces_of(line, normal);
    std::vector<SurfacePatch> patches;
    double length = 0.0;
    for (const TransectPiece& piece : pieces) {
        patches.push_back(cut_patch(mesh, piece.plane, kMargin_m));
        fill_in_sigma(patches.back(), options);
        length += piece.plane.outline[1].x() - piece.plane.outline[0].x();
    }
    Places measured;
    for (const SurfacePatch& patch : patches) measured.push_back(patch.vertices);
    AreaResult result;
    result.coverage = coverage_of(profile_of(pieces, patches, measured));
    Fineness fineness = fineness_of_all(pieces, patches, options);
    keep_shown_noise(pieces, patches, options.noise_share, fineness);
    result.area = {{"name", task.name},
                   {"kind", task.kind},
                   {"length_m", length},
                   {"coverage", result.coverage},
                   {"correlation_length_m", fineness.correlation_length_m}};
    if (!task.label.empty()) result.area["label"] = task.label;
    if (fineness.sigma_m) result.area["sigma_m"] = *fineness.sigma_m;
    if (fineness.sigma_local_m) result.area["sigma_local_m"] = *fineness.sigma_local_m;
    if (fineness.detail_m) result.area["detail_m"] = *fineness.detail_m;
    const Evaluate evaluate = [&](const Places& places, int num_blurs) {
        Profile profile = profile_of(pieces, patches, places);
        for (int i = 0; i < num_blurs; ++i) profile = blurred(profile, *fineness.detail_m);
        return with_hidden(profile, options);
    };
    const std::vector<Simulated> simulated = simulate_figures(
        patches, fineness.correlation_length_m, fineness.detail_m.has_value(), options, evaluate);
    const std::vector<double> bends =
        bend_deviations(patches,
                        fineness.detail_m.value_or(fineness.correlation_length_m),
                        options,
                        [&](const Places& places) { return evaluate(places, 0); });
    const std::vector<double> seen = chain_figures(profile_of(pieces, patches, measured), options);
    for (std::size_t k = 0; k < options.spacings_m.size(); ++k) {
        const FigureKind kind = chain_kind(options.spacings_m[k]);
        const double hidden = std::isfinite(seen[k]) ? simulated[k].measured - seen[k] : 0.0;
        const Estimate estimated = estimate(
            simulated[k],
            options.sigma_doubt,
            {.relative = 0.0, .absolute = std::hypot(hidden, bends.empty() ? 0.0 : bends[k])});
        const auto refused = refused_at(options.spacings_m[k], fineness);
        if (result.coverage < options.least_coverage)
            result.figures.push_back(
                refused_json(task, kind, "less than half of the line was seen"));
        else if (refused)
            result.figures.push_back(refused_json(task, kind, *refused));
        else if (!std::isfinite(estimated.low))
            result.figures.push_back(refused_json(task, kind, "the line is shorter than a link"));
        else
            result.figures.push_back(figure_json(task, kind, estimated));
    }
    return result;
}

}  // namespace divemesh::worker
