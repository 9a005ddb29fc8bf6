#include "worker/reef/measure_outline.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "worker/reef/area_figures.hpp"
#include "worker/reef/figure_json.hpp"
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

struct Seen {
    double num_within = 0.0;
    double num_seen = 0.0;
};

Seen count_seen(const Survey& survey) {
    const HeightGrid grid = survey.grid(survey.patch[0].vertices);
    Seen seen;
    for (std::size_t i = 0; i < survey.within.size(); ++i) {
        seen.num_within += survey.within[i];
        if (grid.heights_m[i] > kUnseen_m) seen.num_seen += 1.0;
    }
    return seen;
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
    const Evaluate evaluate = [&](const Places& places, bool is_blurred) {
        Ground ground{survey.patch[0], places[0], survey.grid(places[0]), R_world_plane};
        if (is_blurred && survey.fineness.detail_m)
            ground.grid = blurred(ground.grid, *survey.fineness.detail_m);
        std::vector<double> values;
        for (std::size_t k = 0; k < kinds.size(); ++k)
            values.push_back(is_blurred && !kinds[k].loses_detail
                                 ? measured[k]
                                 : value_of(kinds[k], ground, measured[k]));
        return values;
    };
    measured = evaluate({survey.patch[0].vertices}, false);
    return simulate_figures(survey.patch, survey.fineness.correlation_length_m, options, evaluate);
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
        if (!refused.back()) taken.push_back(kind);
    }
    const std::vector<Simulated> simulated = simulate(survey, taken, options);
    std::size_t next = 0;
    for (std::size_t k = 0; k < kinds.size(); ++k) {
        if (refused[k]) {
            result.figures.push_back(refused_json(task, kinds[k], *refused[k]));
            continue;
        }
        const Estimate estimated = estimate(simulated[next++], options.sigma_doubt);
        const bool is_known = std::isfinite(estimated.low) && std::isfinite(estimated.high);
        result.figures.push_back(
            is_known ? figure_json(task, kinds[k], estimated)
                     : refused_json(task,
                                    kinds[k],
                                    kinds[k].is_direction ? "too flat to face anywhere"
                                                          : "the ground seen is too small for it"));
    }
}

void add_given(const AreaTask& task, const AreaPlane& plane, AreaResult& result) {
    FigureKind planar{"planar_area", "m2", std::nullopt};
    planar.method = task.is_whole_model ? "samples with surface, seen from above"
                                        : "of the outline as given, along its normal";
    result.figures.push_back(
        figure_json(task, planar, {result.planar_m2, result.planar_m2, result.planar_m2}));
    if (task.is_whole_model) return;
    const double longest = longest_diameter_m(plane.outline);
    FigureKind diameter{"longest_diameter", "m", std::nullopt};
    diameter.method = "between the two farthest corners of the outline as given";
    result.figures.push_back(figure_json(task, diameter, {longest, longest, longest}));
}

nlohmann::json describe(const AreaTask& task, const AreaResult& result, const Fineness& fineness) {
    nlohmann::json json = {{"name", task.name},
                           {"kind", task.kind},
                           {"coverage", result.coverage},
                           {"correlation_length_m", fineness.correlation_length_m}};
    if (!task.label.empty()) json["label"] = task.label;
    if (fineness.sigma_m) json["sigma_m"] = *fineness.sigma_m;
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
        const Seen seen = count_seen(survey);
        result.coverage = seen.num_within > 0.0 ? seen.num_seen / seen.num_within : 0.0;
        if (task.is_whole_model) {
            result.coverage = seen.num_seen > 0.0 ? 1.0 : 0.0;
            result.planar_m2 = seen.num_seen * shape->spacing_m * shape->spacing_m;
        }
    }
    result.area = describe(task, result, survey.fineness);
    result.area["planar_area_m2"] = result.planar_m2;
    add_given(task, plane, result);
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
