#include "worker/reef/outline_survey.hpp"

#include <algorithm>

#include "worker/reef/noise_level.hpp"
#include "worker/reef/rugosity.hpp"

namespace divemesh::reef {
namespace {

constexpr double kMargin_m = 0.05;  // of mesh around an area, because noise moves its border

// Spacings of the finest grid, which divide those of the options, and its max number of samples:
// fine grids are for small areas.
struct GridChoice {
    double spacing_m;
    double max_nodes;
};
constexpr GridChoice kGrids[] = {
    {0.001, 150e3}, {0.002, 150e3}, {0.005, 150e3}, {0.01, 10e6}, {0.05, 10e6}, {0.25, 10e6}};

std::vector<Eigen::Vector3d> cameras_in(const AreaPlane& plane, const MeasureOptions& options) {
    std::vector<Eigen::Vector3d> cameras;
    for (const Eigen::Vector3d& position : options.camera_positions_world)
        cameras.push_back(plane.T_plane_world * position);
    return cameras;
}

// Returns nullopt if even the coarsest has too many samples.
std::optional<GridShape> finest_grid(const Polygon& outline) {
    Eigen::AlignedBox2d box;
    for (const Eigen::Vector2d& corner : outline) box.extend(corner);
    for (const GridChoice& grid : kGrids)
        if (box.volume() <= grid.max_nodes * grid.spacing_m * grid.spacing_m)
            return grid_over(outline, grid.spacing_m);
    return std::nullopt;
}

HeightGrid of_area(const OutlineSurvey& survey, HeightGrid grid) {
    for (std::size_t i = 0; i < survey.within.size(); ++i)
        if (survey.within[i] == 0) grid.heights_m[i] = kUnseen_m;
    return grid;
}

}  // namespace

HeightGrid OutlineSurvey::grid(const std::vector<Eigen::Vector3d>& vertices) const {
    return of_area(*this, sample_heights(vertices, patch[0].triangles, shape));
}

Ground OutlineSurvey::ground(const std::vector<Eigen::Vector3d>& vertices,
                             int num_blurs,
                             HeightGrid bridge(const HeightGrid&)) const {
    const HeightGrid heights = sample_heights(vertices, patch[0].triangles, shape);
    Ground ground{patch[0], vertices, of_area(*this, heights), {}, {}};
    ground.R_world_plane = plane.T_plane_world.linear().transpose();
    // Seen ground beside the outline helps to fill gaps within it.
    if (has_hidden) ground.gaps_filled = of_area(*this, bridge(heights));
    ground.has_hidden = has_hidden;
    const double sharp_m2 = num_blurs > 0 ? grid_area(ground.grid).surface_m2 : 0.0;
    for (int i = 0; i < num_blurs; ++i) {
        ground.grid = blurred(ground.grid, *sampling_resolution.detail_m);
        if (has_hidden)
            ground.gaps_filled = blurred(ground.gaps_filled, *sampling_resolution.detail_m);
    }
    if (num_blurs > 0) ground.lost_to_blur_m2 = sharp_m2 - grid_area(ground.grid).surface_m2;
    if (!has_hidden) ground.gaps_filled = ground.grid;
    return ground;
}

CutOutline cut_outline(const types::Mesh& mesh,
                       const AreaPlane& plane,
                       const MeasureOptions& options) {
    const auto shape = finest_grid(plane.outline);
    CutOutline cut{{plane, {cut_patch(mesh, plane, kMargin_m)}, {}, {}, {}}, shape.has_value()};
    OutlineSurvey& survey = cut.survey;
    fill_in_sigma(survey.patch[0], options);
    survey.sampling_resolution =
        sampling_resolution_of(survey.patch[0], cameras_in(plane, options), options);
    if (!shape) return cut;
    survey.shape = *shape;
    survey.sampling_resolution.min_sample_m = shape->spacing_m;
    survey.within = nodes_within(*shape, plane.outline);
    return cut;
}

double limit_to_noise_level(OutlineSurvey& survey, double max_share) {
    SurfacePatch& patch = survey.patch[0];
    NoiseLevel noise(survey.sampling_resolution.correlation_length_m);
    noise.add(patch, survey.shape);
    const double share = std::min(max_share, noise.share());
    for (double& sigma : patch.sigma_local_m) sigma *= share;
    survey.sampling_resolution.sigma_local_m = sigma_of_most_m(patch, patch.sigma_local_m);
    return share;
}

SeenNodes count_seen(const OutlineSurvey& survey) {
    const HeightGrid grid = survey.grid(survey.patch[0].vertices);
    SeenNodes seen;
    const auto is_seen = [&](int column, int row) {
        return column >= 0 && row >= 0 && column < grid.shape.num_columns &&
               row < grid.shape.num_rows && grid.is_seen(column, row);
    };
    for (int row = 0; row < grid.shape.num_rows; ++row)
        for (int column = 0; column < grid.shape.num_columns; ++column) {
            seen.num_within += survey.within[grid.shape.index(column, row)];
            if (!grid.is_seen(column, row)) continue;
            seen.num_seen += 1.0;
            seen.num_border += 4 - is_seen(column - 1, row) - is_seen(column + 1, row) -
                               is_seen(column, row - 1) - is_seen(column, row + 1);
        }
    return seen;
}

}  // namespace divemesh::reef
