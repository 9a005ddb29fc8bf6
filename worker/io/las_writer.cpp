#include "worker/io/las_writer.hpp"

#include <cmath>
#include <limits>

#include "schemas/error.hpp"
#include "worker/base/atomic_file.hpp"
#include "worker/io/laz_points.hpp"
#include "worker/io/mesh_check.hpp"

namespace divemesh::io {
namespace {

double steps(const LasGrid& grid, const Eigen::Vector3d& point, int axis) {
    return std::round((point[axis] - grid.origin_m[axis]) / LasGrid::kStep_m);
}

// Returns a coordinate as readers of the file compute it.
double stored(const LasGrid& grid, const Eigen::Vector3d& point, int axis) {
    return steps(grid, point, axis) * LasGrid::kStep_m + grid.origin_m[axis];
}

Eigen::Vector3d place_of(const Eigen::Vector3f& p_world, const std::optional<UtmFrame>& utm) {
    Eigen::Vector3d place = p_world.cast<double>();
    if (utm) place.head<2>() = utm->A * Eigen::Vector3d(place.x(), place.y(), 1.0);
    return place;
}

LasGrid grid_of(const types::Mesh& mesh, const std::optional<UtmFrame>& utm) {
    LasGrid grid;
    if (mesh.vertices.empty()) return grid;
    grid.low_m.setConstant(std::numeric_limits<double>::max());
    grid.high_m = -grid.low_m;
    for (const Eigen::Vector3f& vertex : mesh.vertices) {
        const Eigen::Vector3d place = place_of(vertex, utm);
        grid.low_m = grid.low_m.cwiseMin(place);
        grid.high_m = grid.high_m.cwiseMax(place);
    }
    if ((grid.high_m - grid.low_m).maxCoeff() > 4e5)
        throw Error(ErrorCode::BadData,
                    "the mesh is larger than 400 km, which LAS cannot hold in steps of 0.1 mm: "
                    "check its vertices");
    grid.origin_m = (0.5 * (grid.low_m + grid.high_m)).array().round();
    for (int axis = 0; axis < 3; ++axis) {
        grid.low_m[axis] = stored(grid, grid.low_m, axis);
        grid.high_m[axis] = stored(grid, grid.high_m, axis);
    }
    return grid;
}

LasPoint point_of(const types::Mesh& mesh,
                  std::size_t i,
                  const LasGrid& grid,
                  const std::optional<UtmFrame>& utm) {
    const Eigen::Vector3d place = place_of(mesh.vertices[i], utm);
    LasPoint point;
    for (std::size_t axis = 0; axis < 3; ++axis)
        point.steps[axis] = static_cast<std::int32_t>(steps(grid, place, static_cast<int>(axis)));
    if (!mesh.colors.empty()) point.color = mesh.colors[i];
    if (!mesh.sigma_m.empty()) point.sigma_m = mesh.sigma_m[i];
    if (!mesh.num_observations.empty()) point.num_observations = mesh.num_observations[i];
    return point;
}

// The points of a file that is not compressed.
class PlainPoints {
public:
    explicit PlainPoints(base::AtomicFile& file) : file_(file) {}
    void add(const LasPoint& point) {
        put_point(record_, point);
        record_.flush_to(file_);
    }
    void finish() {}

private:
    base::AtomicFile& file_;
    Record record_;
};

template <typename Points>
void write_points(Points points,
                  const types::Mesh& mesh,
                  const LasGrid& grid,
                  const std::optional<UtmFrame>& utm) {
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) points.add(point_of(mesh, i, grid, utm));
    points.finish();
}

}  // namespace

void write_las(const std::filesystem::path& file,
               const types::Mesh& mesh,
               const LasDescription& description,
               LasStorage storage) {
    check_mesh(mesh);
    const LasGrid grid = grid_of(mesh, description.utm);
    const std::string header = las_header(grid, description, mesh.vertices.size(), storage);
    base::AtomicFile output(file);
    output.write(header);
    if (storage == LasStorage::Laszip)
        write_points(LazPoints(output, header.size()), mesh, grid, description.utm);
    else
        write_points(PlainPoints(output), mesh, grid, description.utm);
    output.commit();
}

}  // namespace divemesh::io
