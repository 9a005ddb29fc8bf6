#include "worker/reef/measure_outline.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "worker/reef/area_figures.hpp"
#include "worker/reef/figure_json.hpp"
#include "worker/reef/fractal_dimension.hpp"
#include "worker/reef/shown_noise.hpp"
#include "worker/reef/simulate_figures.hpp"

namespace divemesh::worker {
namespace {

constexpr double kMargin_m = 0.05;  // of mesh around an area: noise moves what lies on its border

// Spacings of the finest grid, which divide those that figures are asked at, and how many samples
// it may have: fine grids are for small areas.
struct GridChoice {
    double spacing_m;
    double most_nodes;
};
constexpr GridChoice kGrids[] = {
    {0.001, 150e3}, {0.002, 150e3}, {0.005, 150e3}, {0.01, 10e6}, {0.05, 10e6}, {0.25, 10e6}};

std::vector<Eigen::Vector3d> cameras_in(const AreaPlane& plane, const MeasureOptions& options) {
    std::vector<Eigen::Vector3d> cameras;
    for (const Eigen::Vector3d& position : options.camera_positions_world)
        cameras.push_back(plane.T_plane_world * position);
    return cameras;
}

// Nothing when the coarsest has too many samples.
std::optional<GridShape> finest_grid(const Polygon& outline) {
    Eigen::AlignedBox2d box;
    for (const Eigen::Vector2d& corner : outline) box.extend(corner);
    for (const GridChoice& grid : kGrids)
        if (box.volume() <= grid.most_nodes * grid.spacing_m * grid.spacing_m)
            return grid_over(outline, grid.spacing_m);
    return std::nullopt;
}

// The part of a mesh over an outline with all that its figures are taken from.
struct Survey {
    AreaPlane plane;
    std::vector<SurfacePatch> patch;  // one
    Fineness fineness;
    GridShape shape;
    std::vector<std::uint8_t> within;

    HeightGrid grid(const std::vector<Eigen::Vector3d>& vertices) const {
        HeightGrid grid = sample_heights(vertices, patch[0].triangles, shape);
        for (std::size_t i = 0; i < within.size(); ++i)
            if (within[i] == 0) grid.heights_m[i] = kUnseen_m;
        return grid;
    }
};

// Answers the share that was kept.
double keep_shown_noise(Survey& survey, double most) {
    SurfacePatch& patch = survey.patch[0];
    ShownNoise noise(survey.fineness.correlation_length_m);
    noise.add(patch, survey.shape);
    const double share = std::min(most, noise.share());
    for (double& sigma : patch.sigma_local_m) sigma *= share;
    survey.fineness.sigma_local_m = typical_sigma_m(patch.sigma_local_m);
    return share;
}

struct Seen {
    double num_within = 0.0;
    double num_seen = 0.0;
    double num_border = 0.0;  // sides between seen nodes and what was not seen
};

Seen count_seen(const Survey& survey) {
    const HeightGrid grid = survey.grid(survey.patch[0].vertices);
    Seen seen;
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

// Of an area whose border is known to half the detail that the surface holds, every such stretch
// of it independently.
double border_sigma_m2(double border_m, double detail_m) {
    return detail_m * std::sqrt(border_m * detail_m / 12.0);
}

double value_of(const FigureKind& kind, const Ground& ground, double near) {
    const double value = kind.measure(ground).value_or(std::nan(""));
    if (!kind.is_direction || std::isnan(near)) return value;
    return value + 360.0 * std::round((near - value) / 360.0);
}

std::vector<Simulated> simulate(const Survey& survey,
                                const std::vector<FigureKind>& kinds,
                                const MeasureOptions& options) {
    std::vector<double> measured(kinds.size(), std::nan(""));
    const Eigen::Matrix3d R_world_plane = survey.plane.T_plane_world.linear().transpose();
    const Evaluate evaluate = [&](const Places& places, int num_blurs) {
        Ground ground{survey.patch[0], places[0], survey.grid(places[0]), R_world_plane};
        for (int i = 0; i < num_blurs; ++i)
            ground.grid = blurred(ground.grid, *survey.fineness.detail_m);
        std::vector<double> values;
        for (std::size_t k = 0; k < kinds.size(); ++k)
            values.push_back(num_blurs > 0 && !kinds[k].loses_detail
                                 ? std::nan("")
                                 : value_of(kinds[k], ground, measured[k]));
        return values;
    };
    measured = evaluate({survey.patch[0].vertices}, 0);
    return simulate_figures(survey.patch,
                            survey.fineness.correlation_length_m,
                            survey.fineness.detail_m.has_value(),
                            options,
                            evaluate);
}

std::optional<std::string> refusal(const FigureKind& kind,
                                   const AreaTask& task,
                                   const Fineness& fineness,
                                   double coverage,
                                   const MeasureOptions& options) {
    if (task.is_whole_model && kind.figure == "volume")
        return "the whole model has no plane of its own; give an area";
    const double least =
        kind.is_extreme ? options.least_coverage_of_extremes : options.least_coverage;
    if (!task.is_whole_model && coverage < least)
        return std::to_string(std::lround(100.0 * coverage)) +
               " % of the area was seen, less than " + std::to_string(std::lround(100.0 * least)) +
               " %";
    return kind.resolution_m ? refused_at(*kind.resolution_m, fineness) : std::nullopt;
}

// Nothing where heights within a square of the figure's resolution differ by more than three sigma
// of the surface: a fractal dimension of less is one of errors, about 2.5.
std::optional<std::string> too_flat(const FigureKind& kind, const Survey& survey) {
    if (!kind.needs_relief || !kind.resolution_m) return std::nullopt;
    const std::vector<double> ranges =
        height_ranges(survey.grid(survey.patch[0].vertices), *kind.resolution_m);
    if (ranges.empty()) return std::nullopt;
    const double mean =
        std::accumulate(ranges.begin(), ranges.end(), 0.0) / static_cast<double>(ranges.size());
    const double least = 3.0 * survey.fineness.sigma_m.value_or(0.0);
    if (mean > least) return std::nullopt;
    return "too flat: heights within " + length_text(*kind.resolution_m) + " differ by " +
           length_text(mean) + ", not by more than 3 sigma of the surface, " + length_text(least);
}

SharedError shared_error(const FigureKind& kind,
                         const AreaResult& result,
                         const MeasureOptions& options) {
    return {std::abs(kind.length_power) * options.scale_sigma,
            kind.is_from_plane ? options.sigma_shared_m * result.coverage * result.planar_m2 : 0.0};
}

// Those that can be taken are; the others say why not, in their place.
void add_figures(const std::vector<FigureKind>& kinds,
                 const AreaTask& task,
                 const Survey& survey,
                 const MeasureOptions& options,
                 AreaResult& result) {
    std::vector<std::optional<std::string>> refused;
    std::vector<FigureKind> taken;
    for (const FigureKind& kind : kinds) {
        refused.push_back(refusal(kind, task, survey.fineness, result.coverage, options));
        if (!refused.back()) refused.back() = too_flat(kind, survey);
        if (!refused.back()) taken.push_back(kind);
    }
    const std::vector<Simulated> simulated = simulate(survey, taken, options);
    std::size_t next = 0;
    for (std::size_t k = 0; k < kinds.size(); ++k) {
        if (refused[k]) {
            result.figures.push_back(refused_json(task, kinds[k], *refused[k]));
            continue;
        }
        const Estimate estimated = estimate(
            simulated[next++], options.sigma_doubt, shared_error(kinds[k], result, options));
        const bool is_known = std::isfinite(estimated.low) && std::isfinite(estimated.high);
        if (estimated.high < kinds[k].lowest || estimated.low > kinds[k].highest) {
            result.figures.push_back(refused_json(
                task, kinds[k], "all of its interval lies beyond what the figure can be"));
            continue;
        }
        result.figures.push_back(
            is_known ? figure_json(task, kinds[k], estimated)
                     : refused_json(task,
                                    kinds[k],
                                    kinds[k].is_direction ? "too flat to face anywhere"
                                                          : "the ground seen is too small for it"));
    }
}

void add_given(const AreaTask& task,
               const AreaPlane& plane,
               const MeasureOptions& options,
               AreaResult& result) {
    const auto of_value = [&](double value, int length_power, double sigma) {
        return estimate({value, value, {}, {}}, 0.0, {length_power * options.scale_sigma, sigma});
    };
    FigureKind planar{"planar_area", "m2", std::nullopt};
    planar.method = task.is_whole_model ? "samples with surface, seen from above"
                                        : "of the outline as given, along its normal";
    result.figures.push_back(
        figure_json(task, planar, of_value(result.planar_m2, 2, result.border_sigma_m2)));
    if (task.is_whole_model) return;
    const double longest = longest_diameter_m(plane.outline);
    FigureKind diameter{"longest_diameter", "m", std::nullopt};
    diameter.method = "between the two farthest corners of the outline as given";
    result.figures.push_back(figure_json(task, diameter, of_value(longest, 1, 0.0)));
}

nlohmann::json describe(const AreaTask& task, const AreaResult& result, const Fineness& fineness) {
    nlohmann::json json = {{"name", task.name},
                           {"kind", task.kind},
                           {"coverage", result.coverage},
                           {"correlation_length_m", fineness.correlation_length_m}};
    if (!task.label.empty()) json["label"] = task.label;
    if (fineness.sigma_m) json["sigma_m"] = *fineness.sigma_m;
    if (fineness.sigma_local_m) json["sigma_local_m"] = *fineness.sigma_local_m;
    if (fineness.detail_m) json["detail_m"] = *fineness.detail_m;
    return json;
}

}  // namespace

AreaResult measure_outline(const Mesh& mesh,
                           const AreaTask& task,
                           const AreaPlane& plane,
                           const MeasureOptions& options) {
    AreaResult result;
    result.planar_m2 = area_m2(plane.outline);
    const auto shape = finest_grid(plane.outline);
    Survey survey{plane, {cut_patch(mesh, plane, kMargin_m)}, {}, {}, {}};
    fill_in_sigma(survey.patch[0], options);
    survey.fineness = fineness_of(survey.patch[0], cameras_in(plane, options), options);
    if (shape) {
        survey.shape = *shape;
        survey.fineness.least_sample_m = shape->spacing_m;
        survey.within = nodes_within(*shape, plane.outline);
        result.noise_share = keep_shown_noise(survey, options.noise_share);
        const Seen seen = count_seen(survey);
        result.coverage = seen.num_within > 0.0 ? seen.num_seen / seen.num_within : 0.0;
        if (task.is_whole_model) {
            result.coverage = seen.num_seen > 0.0 ? 1.0 : 0.0;
            result.planar_m2 = seen.num_seen * shape->spacing_m * shape->spacing_m;
            result.border_sigma_m2 =
                border_sigma_m2(seen.num_border * shape->spacing_m,
                                std::max(shape->spacing_m, survey.fineness.detail_m.value_or(0.0)));
        }
    }
    result.area = describe(task, result, survey.fineness);
    result.area["planar_area_m2"] = result.planar_m2;
    add_given(task, plane, options, result);
    const auto kinds =
        area_figures(options, survey.fineness, finest_spacing_m(options, survey.fineness));
    if (shape && result.coverage > 0.0) {
        add_figures(kinds, task, survey, options, result);
        return result;
    }
    for (const FigureKind& kind : kinds)
        result.figures.push_back(refused_json(
            task, kind, shape ? "none of the area was seen" : "too large for samples of 25 cm"));
    return result;
}

}  // namespace divemesh::worker
