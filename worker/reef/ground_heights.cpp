#include "worker/reef/ground_heights.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "schemas/error.hpp"
#include "worker/base/text.hpp"
#include "worker/reef/fill_gaps.hpp"

namespace divemesh::reef {
namespace {

using Box = Eigen::AlignedBox2d;

constexpr double kMinSpacing_m = 0.005;
constexpr double kMaxNodes = 4e6;

Box box_of(const Polygon& polygon) {
    Box box;
    for (const Eigen::Vector2d& point : polygon) box.extend(point);
    return box;
}

std::string box_text(const Box& box) {
    return "x " + base::significant(box.min().x()) + " to " + base::significant(box.max().x()) +
           ", y " + base::significant(box.min().y()) + " to " + base::significant(box.max().y()) +
           " m";
}

// Returns the part of the surface that polygons are over.
Box shared_box(const Box& surface, const std::vector<Polygon>& polygons) {
    Box all;
    Box shared;
    for (const Polygon& polygon : polygons) {
        const Box box = box_of(polygon);
        all.extend(box);
        if (!box.intersection(surface).isEmpty()) shared.extend(box.intersection(surface));
    }
    if (shared.isEmpty())
        throw Error(ErrorCode::BadData,
                    "none of the areas is over the surface: they are at " + box_text(all) +
                        " in its world, the surface at " + box_text(surface) +
                        ": check their coordinate system, or --areas-crs");
    return shared;
}

GridShape shape_over(const Box& box) {
    const Eigen::Vector2d size_m = box.sizes();
    const double spacing_m = std::max(
        {kMinSpacing_m, std::sqrt(size_m.prod() / kMaxNodes), 2.0 * size_m.sum() / kMaxNodes});
    GridShape shape;
    shape.origin_m = box.min();
    shape.spacing_m = spacing_m;
    shape.num_columns = static_cast<int>(std::ceil(size_m.x() / spacing_m)) + 1;
    shape.num_rows = static_cast<int>(std::ceil(size_m.y() / spacing_m)) + 1;
    return shape;
}

int nearest_node(double distance_m, double spacing_m, int num_nodes) {
    return static_cast<int>(
        std::clamp(std::round(distance_m / spacing_m), 0.0, static_cast<double>(num_nodes - 1)));
}

}  // namespace

GroundHeights::GroundHeights(const types::Mesh& mesh, const std::vector<Polygon>& polygons) {
    std::vector<Eigen::Vector3d> vertices;
    Box surface;
    for (const Eigen::Vector3f& vertex : mesh.vertices) {
        vertices.emplace_back(vertex.cast<double>());
        surface.extend(vertices.back().head<2>());
    }
    // Where the box of a polygon has no surface in it, the whole surface is its surroundings.
    const GridShape shape = shape_over(shared_box(surface, polygons));
    grid_ = gaps_filled(sample_heights(vertices, mesh.triangles, shape));
    if (std::none_of(grid_.heights_m.begin(), grid_.heights_m.end(), [](double height_m) {
            return height_m > kUnseen_m;
        }))
        grid_ = gaps_filled(sample_heights(vertices, mesh.triangles, shape_over(surface)));
}

double GroundHeights::at(const Eigen::Vector2d& p_world) const {
    const GridShape& shape = grid_.shape;
    const Eigen::Vector2d p_grid = p_world - shape.origin_m;
    return grid_.at(nearest_node(p_grid.x(), shape.spacing_m, shape.num_columns),
                    nearest_node(p_grid.y(), shape.spacing_m, shape.num_rows));
}

}  // namespace divemesh::reef
