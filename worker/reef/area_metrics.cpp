#include "worker/reef/area_metrics.hpp"

#include <algorithm>
#include <cmath>

#include "worker/base/angle.hpp"
#include "worker/reef/complexity_relation.hpp"
#include "worker/reef/fractal_dimension.hpp"
#include "worker/reef/heights.hpp"
#include "worker/reef/rugosity.hpp"
#include "worker/reef/terrain.hpp"

namespace divemesh::reef {
namespace {

using Kinds = std::vector<MetricKind>;

// Returns a metric with hidden ground. Ground hidden behind a step is bridged by a steeper surface
// than the seen ground. Ground that the dive merely did not cover is not, and then counts like the
// seen ground.
std::optional<double> with_hidden(const std::optional<double>& gaps_filled,
                                  const std::optional<double>& seen) {
    return std::max(gaps_filled, seen);
}

// The ground of an area that was not seen.
struct HiddenGround {
    double planar_m2 = 0.0;
    double surface_m2 = 0.0;  // with it the highest surface is as rough as its rugosity says
    double border_m2 = 0.0;   // between samples: may be seen or hidden
};

// Returns nullopt if too little ground was seen to tell.
std::optional<HiddenGround> hidden_ground(const Ground& ground) {
    if (!ground.has_hidden) return HiddenGround{};
    const GridArea seen = grid_area(ground.grid);
    if (seen.planar_m2 <= 0.0) return std::nullopt;
    const GridArea whole = grid_area(ground.gaps_filled);
    const double seen_rugosity = seen.surface_m2 / seen.planar_m2;
    const double whole_rugosity = std::max(seen_rugosity, whole.surface_m2 / whole.planar_m2);
    const double seen_m2 = planar_area_m2(ground.grid);
    const double whole_m2 = planar_area_m2(ground.gaps_filled);
    HiddenGround hidden;
    hidden.planar_m2 = whole_m2 - seen_m2;
    hidden.surface_m2 = whole_rugosity * whole_m2 - seen_rugosity * seen_m2;
    hidden.border_m2 = seen_rugosity * (whole.planar_m2 - seen.planar_m2 - hidden.planar_m2);
    return hidden;
}

// Returns one standard deviation. Hidden ground may as well be flat, or twice as rough: of a
// quantity that is never negative, and of which only the mean is known, the standard deviation is
// that mean (the exponential distribution).
double hidden_area_deviation_m2(const Ground& ground) {
    const HiddenGround hidden = hidden_ground(ground).value_or(HiddenGround{});
    return std::hypot(hidden.surface_m2 - hidden.planar_m2, hidden.border_m2);
}

MetricKind surface_area_kind(const SamplingResolution& sampling_resolution) {
    return {.metric = "surface_area",
            .unit = "m2",
            .resolution_m = sampling_resolution.detail_m,
            .method = "triangles of the mesh over the area, every sheet (habtools surface_area)",
            .lowest = 0.0,
            .loses_detail = true,
            .length_power = 2,
            .measure = [](const Ground& ground) -> std::optional<double> {
                const auto hidden = hidden_ground(ground);
                if (!hidden) return std::nullopt;
                // Blurred as the highest surface is.
                return surface_area_m2(ground.patch, ground.vertices) - ground.lost_to_blur_m2 +
                       hidden->surface_m2;
            },
            .hidden_deviation = hidden_area_deviation_m2};
}

MetricKind rugosity_kind(double spacing_m) {
    return {.metric = "rugosity",
            .unit = "",
            .resolution_m = spacing_m,
            .method =
                "area of the highest surface sampled at the resolution over planar area "
                "(habtools rg, method area)",
            .lowest = 1.0,
            .loses_detail = true,
            .measure = [spacing_m](const Ground& ground) {
                return with_hidden(rugosity(ground.gaps_filled_at(spacing_m)),
                                   rugosity(ground.at(spacing_m)));
            }};
}

MetricKind rugosity_by_height_variation_kind(double spacing_m) {
    return {.metric = "rugosity_hvar",
            .unit = "",
            .resolution_m = spacing_m,
            .method =
                "mean of sqrt(1 + H0^2 / (2 L0^2)) over squares (habtools rg, method hvar; "
                "Torres-Pulliza et al. 2020)",
            .lowest = 1.0,
            .loses_detail = true,
            .measure = [spacing_m](const Ground& ground) {
                return with_hidden(rugosity_by_height_variation(ground.gaps_filled, spacing_m),
                                   rugosity_by_height_variation(ground.grid, spacing_m));
            }};
}

MetricKind height_range_kind() {
    return {.metric = "height_range",
            .unit = "m",
            .method = "highest minus lowest along the normal (habtools hr)",
            .lowest = 0.0,
            .is_extreme = true,
            .loses_detail = true,
            .length_power = 1,
            .measure = [](const Ground& ground) { return height_range(ground.grid); }};
}

MetricKind volume_kind() {
    return {.metric = "volume",
            .unit = "m3",
            .method =
                "between the highest surface and the plane at the mean height of the corners, "
                "above minus below",
            .is_extreme = true,
            .length_power = 3,
            .is_from_plane = true,
            .measure = [](const Ground& ground) {
                return std::optional(volume_over_plane(ground.gaps_filled));
            }};
}

std::optional<Eigen::Vector3d> normal_world(const Ground& ground) {
    const auto normal = mean_normal(ground.gaps_filled);
    if (!normal) return std::nullopt;
    return ground.R_world_plane * *normal;
}

MetricKind slope_kind() {
    return {.metric = "slope",
            .unit = "deg",
            .method = "of the plane fitted to the heights, from the horizontal",
            .lowest = 0.0,
            .highest = 180.0,
            .measure = [](const Ground& ground) -> std::optional<double> {
                const auto normal = normal_world(ground);
                if (!normal) return std::nullopt;
                return std::atan2(normal->head<2>().norm(), normal->z()) * base::kDegPerRad;
            }};
}

MetricKind aspect_kind() {
    return {.metric = "aspect",
            .unit = "deg",
            .method = "downhill of that plane, from the world's y towards its x",
            .is_direction = true,
            .measure = [](const Ground& ground) -> std::optional<double> {
                const auto normal = normal_world(ground);
                constexpr double kMinSlope = 0.0175;  // 1 degree: flat ground has no aspect
                if (!normal || normal->head<2>().norm() < kMinSlope) return std::nullopt;
                const double angle = std::atan2(normal->x(), normal->y()) * base::kDegPerRad;
                return angle < 0.0 ? angle + 360.0 : angle;
            }};
}

void add_terrain(Kinds& kinds, double spacing_m) {
    const auto add = [&](MetricKind kind, double Terrain::*field, double factor) {
        kind.resolution_m = spacing_m;
        kind.loses_detail = true;
        kind.measure = [=](const Ground& ground) -> std::optional<double> {
            const auto measured = terrain(ground.at(spacing_m));
            if (!measured) return std::nullopt;
            return (*measured).*field * factor;
        };
        kinds.push_back(std::move(kind));
    };
    add({.metric = "mean_slope",
         .unit = "deg",
         .method = "of windows of 3 x 3 samples to the area's plane (Horn 1981)",
         .lowest = 0.0},
        &Terrain::mean_slope,
        base::kDegPerRad);
    add({.metric = "curvature",
         .unit = "1/m",
         .method = "mean, hills positive (Zevenbergen and Thorne 1987)",
         .length_power = -1},
        &Terrain::mean_curvature,
        1.0);
    add({.metric = "curvature_deviation",
         .unit = "1/m",
         .method = "standard deviation of the curvature",
         .lowest = 0.0,
         .length_power = -1},
        &Terrain::curvature_deviation,
        1.0);
    add({.metric = "vrm",
         .unit = "",
         .method = "vector ruggedness, windows of 3 x 3 (Sappington et al. 2007)",
         .lowest = 0.0,
         .highest = 1.0},
        &Terrain::vrm,
        1.0);
}

void add_fractal_dimensions(Kinds& kinds, double finest_m) {
    // In habtools the smallest square has ten samples.
    const double sample_m = 0.2 * finest_m;
    const MetricKind hvar{
        .metric = "fractal_dimension_hvar",
        .unit = "",
        .resolution_m = 2.0 * finest_m,
        .method = "height variation over scales halved down to the resolution (habtools fd, hvar)",
        .lowest = 2.0,
        .highest = 3.0,
        .loses_detail = true,
        .needs_height_spread = true,
        .measure = [=](const Ground& ground) {
            return fractal_dimension_by_height_variation(ground.near(sample_m), 2.0 * finest_m);
        }};
    kinds.push_back(hvar);
    MetricKind cubes = hvar;
    cubes.metric = "fractal_dimension_cubes";
    cubes.method =
        "cubes that hold the surface, sides halved down to the resolution (habtools fd, "
        "cubes)";
    cubes.measure = [=](const Ground& ground) {
        return fractal_dimension_by_cubes(ground.near(sample_m), 2.0 * finest_m);
    };
    kinds.push_back(cubes);
    MetricKind relation = hvar;
    relation.metric = "fractal_dimension_rdh";
    relation.resolution_m = finest_m;
    relation.method =
        "from rugosity and height range (habtools rdh_theory; Torres-Pulliza et al. "
        "2020)";
    relation.is_extreme = true;
    relation.measure = [=](const Ground& ground) -> std::optional<double> {
        const auto range = height_range(ground.grid);
        const auto ratio = rugosity(ground.at(finest_m));
        const GridShape& shape = ground.grid.shape;
        const double extent = (std::min(shape.num_columns, shape.num_rows) - 1) * shape.spacing_m;
        if (!range || !ratio || !(*range > 0.0) || !(*ratio > 1.0) || extent < 2.0 * finest_m)
            return std::nullopt;
        return fractal_dimension_from(*ratio, *range, {extent, finest_m});
    };
    kinds.push_back(relation);
}

}  // namespace

HeightGrid Ground::near(double spacing_m) const {
    return every(grid, std::max(1, static_cast<int>(spacing_m / grid.shape.spacing_m + 1e-9)));
}

HeightGrid Ground::at(double spacing_m) const {
    return every(grid, static_cast<int>(std::lround(spacing_m / grid.shape.spacing_m)));
}

HeightGrid Ground::gaps_filled_at(double spacing_m) const {
    return every(gaps_filled, static_cast<int>(std::lround(spacing_m / grid.shape.spacing_m)));
}

std::vector<MetricKind> area_metrics(const MeasureOptions& options,
                                     const SamplingResolution& sampling_resolution,
                                     std::optional<double> finest_m) {
    Kinds kinds;
    kinds.push_back(surface_area_kind(sampling_resolution));
    for (const double spacing_m : options.spacings_m) kinds.push_back(rugosity_kind(spacing_m));
    for (const double spacing_m : options.spacings_m)
        kinds.push_back(rugosity_by_height_variation_kind(spacing_m));
    kinds.insert(kinds.end(), {height_range_kind(), volume_kind(), slope_kind(), aspect_kind()});
    const double finest = finest_m.value_or(options.spacings_m.back());
    add_terrain(kinds, finest);
    add_fractal_dimensions(kinds, finest);
    return kinds;
}

}  // namespace divemesh::reef
