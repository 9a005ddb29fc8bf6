#include "worker/reef/measure_areas.hpp"

#include <algorithm>

#include "schemas/error.hpp"
#include "worker/io/mesh_check.hpp"
#include "worker/reef/measure_labels.hpp"
#include "worker/reef/measure_outline.hpp"
#include "worker/reef/unknown_vertical.hpp"

namespace divemesh::reef {
namespace {

using nlohmann::json;

// Returns a level plane around the whole mesh.
AreaPlane plane_of_all(const types::Mesh& mesh) {
    Eigen::AlignedBox3d box(mesh.vertices[0].cast<double>());
    for (const Eigen::Vector3f& vertex : mesh.vertices) box.extend(vertex.cast<double>());
    AreaPlane plane;
    plane.T_plane_world.translation() = -box.min();
    const Eigen::Vector3d size = box.sizes();
    plane.outline = {{0.0, 0.0}, {size.x(), 0.0}, {size.x(), size.y()}, {0.0, size.y()}};
    return plane;
}

AreaResult measure(const types::Mesh& mesh, const Area& area, const MeasureOptions& options) {
    const AreaTask task{area.name, area.label, std::string(to_string(area.kind))};
    if (area.kind == AreaKind::Transect)
        return measure_transect(
            mesh, task, area.points, area.normal.value_or(Eigen::Vector3d::UnitZ()), options);
    return measure_outline(mesh, task, plane_of(area), options);
}

bool is_survey(const Area& area) { return area.kind == AreaKind::Quadrat && area.label.empty(); }

void append(const json& metrics, json& all) {
    all.insert(all.end(), metrics.begin(), metrics.end());
}

void check(const types::Mesh& mesh, const AreaSet& set) {
    io::check_mesh(mesh);
    if (mesh.triangles.empty())
        throw Error(ErrorCode::InvalidArgument, "the mesh has no triangles to measure");
    if (set.frame != AreaFrame::World)
        throw Error(ErrorCode::InvalidArgument,
                    "the areas are in the ground truth's frame: give a ground truth");
}

json measure_all(const types::Mesh& mesh, const AreaSet& set, MeasureOptions options) {
    AreaTask whole{std::string(kWholeModel), "", "whole"};
    whole.is_whole_model = true;
    const AreaResult all = measure_outline(mesh, whole, plane_of_all(mesh), options);
    // The stated noise is too large by the same factor all over a dive, and smooth ground shows it.
    options.noise_share = std::min(options.noise_share, all.noise_share);
    json areas = json::array({all.area});
    json metrics = all.metrics;
    SurveyedGround ground{std::string(kWholeModel), all.planar_m2, {}};
    double seen_in_quadrats = 0.0;
    for (const Area& area : set.areas) {
        const AreaResult result = measure(mesh, area, options);
        areas.push_back(result.area);
        append(result.metrics, metrics);
        if (!is_survey(area)) continue;
        ground.quadrats.push_back(plane_of(area));
        seen_in_quadrats += result.coverage * result.planar_m2;
    }
    if (!ground.quadrats.empty()) {
        ground.name = "quadrats";
        ground.seen_m2 = seen_in_quadrats;
    }
    append(measure_labels(set, ground, options), metrics);
    return {{"areas", areas}, {"figures", metrics}};
}

}  // namespace

json measure_areas(const types::Mesh& mesh, const AreaSet& set, MeasureOptions options) {
    check(mesh, set);
    if (options.vertical_is_known) return measure_all(mesh, set, options);
    json result = measure_all(mesh, facing_cameras(set, options.camera_positions_world), options);
    refuse_by_vertical(set, result);
    return result;
}

}  // namespace divemesh::reef
