#include <algorithm>
#include <cmath>

#include "worker/reef/area_figures.hpp"
#include "worker/reef/figure_json.hpp"
#include "worker/reef/measure_outline.hpp"
#include "worker/reef/rugosity.hpp"
#include "worker/reef/shown_noise.hpp"
#include "worker/reef/simulate_figures.hpp"

namespace divemesh::worker {
namespace {

constexpr double kMargin_m = 0.05;
constexpr double kStep_m = 0.005;  // of which every spacing of the options is a multiple

// A straight piece of the line with the mesh around it; samples at whole steps of the line.
struct Piece {
    AreaPlane plane;
    GridShape shape;  // one row
    double first_along_m = 0.0;
    double datum_m = 0.0;  // of its heights, against the first piece's
};

std::vector<Piece> pieces_of(const std::vector<Eigen::Vector3d>& line,
                             const Eigen::Vector3d& normal) {
    std::vector<Piece> pieces;
    double along = 0.0;
    std::int64_t next = 0;  // step
    for (std::size_t i = 1; i < line.size(); ++i) {
        Piece piece;
        piece.plane = plane_along(line[i - 1], line[i], normal);
        const double length = piece.plane.outline[1].x() - piece.plane.outline[0].x();
        constexpr double kSlack_m = 1e-6;
        const auto end =
            static_cast<std::int64_t>(std::floor((along + length + kSlack_m) / kStep_m));
        piece.first_along_m = static_cast<double>(next) * kStep_m;
        piece.shape.origin_m = {piece.first_along_m - along, 0.0};
        piece.shape.spacing_m = kStep_m;
        piece.shape.num_columns = static_cast<int>(std::max<std::int64_t>(0, end - next + 1));
        piece.shape.num_rows = 1;
        piece.datum_m = normal.dot(line[i - 1] - line[0]);
        pieces.push_back(piece);
        next = std::max(next, end + 1);
        along += length;
    }
    return pieces;
}

std::vector<ProfilePoint> profile_of(const std::vector<Piece>& pieces,
                                     const std::vector<SurfacePatch>& patches,
                                     const Places& places) {
    std::vector<ProfilePoint> profile;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        const HeightGrid heights = sample_heights(places[i], patches[i].triangles, pieces[i].shape);
        for (int k = 0; k < pieces[i].shape.num_columns; ++k)
            profile.push_back(
                {pieces[i].first_along_m + k * kStep_m,
                 heights.is_seen(k, 0) ? heights.at(k, 0) + pieces[i].datum_m : kUnseen_m});
    }
    return profile;
}

std::vector<ProfilePoint> every(const std::vector<ProfilePoint>& profile, double spacing_m) {
    const auto step = static_cast<std::size_t>(std::lround(spacing_m / kStep_m));
    std::vector<ProfilePoint> links;
    for (std::size_t i = 0; i < profile.size(); i += step) links.push_back(profile[i]);
    return links;
}

std::vector<ProfilePoint> blurred(const std::vector<ProfilePoint>& profile, double side_m) {
    const auto radius = static_cast<std::ptrdiff_t>(std::lround(0.5 * side_m / kStep_m));
    std::vector<ProfilePoint> out = profile;
    const auto num = static_cast<std::ptrdiff_t>(profile.size());
    for (std::ptrdiff_t i = 0; i < num; ++i) {
        if (!(profile[i].height_m > kUnseen_m)) continue;
        double sum = 0.0;
        int num_seen = 0;
        for (std::ptrdiff_t k = std::max<std::ptrdiff_t>(0, i - radius);
             k <= std::min(num - 1, i + radius);
             ++k) {
            if (!(profile[k].height_m > kUnseen_m)) continue;
            sum += profile[k].height_m;
            ++num_seen;
        }
        out[i].height_m = sum / num_seen;
    }
    return out;
}

double coverage_of(const std::vector<ProfilePoint>& profile) {
    const auto num = std::count_if(profile.begin(), profile.end(), [](const ProfilePoint& point) {
        return point.height_m > kUnseen_m;
    });
    return profile.empty() ? 0.0 : static_cast<double>(num) / static_cast<double>(profile.size());
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
Fineness fineness_of_all(const std::vector<Piece>& pieces,
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

void keep_shown_noise(const std::vector<Piece>& pieces,
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
    const std::vector<Piece> pieces = pieces_of(line, normal);
    std::vector<SurfacePatch> patches;
    double length = 0.0;
    for (const Piece& piece : pieces) {
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
        std::vector<ProfilePoint> profile = profile_of(pieces, patches, places);
        for (int i = 0; i < num_blurs; ++i) profile = blurred(profile, *fineness.detail_m);
        std::vector<double> values;
        for (const double spacing_m : options.spacings_m)
            values.push_back(chain_rugosity(every(profile, spacing_m)).value_or(std::nan("")));
        return values;
    };
    const std::vector<Simulated> simulated = simulate_figures(
        patches, fineness.correlation_length_m, fineness.detail_m.has_value(), options, evaluate);
    for (std::size_t k = 0; k < options.spacings_m.size(); ++k) {
        const FigureKind kind = chain_kind(options.spacings_m[k]);
        const Estimate estimated = estimate(simulated[k], options.sigma_doubt);
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
