#include "worker/evaluation/surface_samples.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "schemas/error.hpp"
#include "worker/base/hashed_random.hpp"
#include "worker/types/triangle_area.hpp"

namespace divemesh::evaluation {
namespace {

// Returns a number in [0, 1) that depends only on its arguments.
double uniform(std::uint64_t seed, std::uint64_t index) {
    return base::to_unit(base::hash64(seed * 0xd1342543de82ef95U + index * 0x9e3779b97f4a7c15U));
}

Eigen::Vector3f point_in_triangle(const types::Mesh& mesh,
                                  const std::array<std::uint32_t, 3>& triangle,
                                  double u,
                                  double v) {
    const auto root = static_cast<float>(std::sqrt(u));
    const auto share = static_cast<float>(v);
    const Eigen::Vector3f& a = mesh.vertices[triangle[0]];
    return a + root * (1.0F - share) * (mesh.vertices[triangle[1]] - a) +
           root * share * (mesh.vertices[triangle[2]] - a);
}

}  // namespace

double surface_area_m2(const types::Mesh& mesh) {
    double area = 0.0;
    for (const auto& triangle : mesh.triangles) area += types::triangle_area_m2(mesh, triangle);
    return area;
}

std::vector<Eigen::Vector3f> sample_surface(const types::Mesh& mesh,
                                            std::int64_t num_samples,
                                            std::uint64_t seed) {
    const double total = surface_area_m2(mesh);
    if (!(total > 0.0))
        throw Error(ErrorCode::BadData, "the mesh has no triangle with an area: check the file");
    std::vector<Eigen::Vector3f> samples;
    samples.reserve(static_cast<std::size_t>(num_samples));
    std::size_t triangle = 0;
    double covered = types::triangle_area_m2(mesh, mesh.triangles[0]);
    for (std::int64_t i = 0; i < num_samples; ++i) {
        const auto number = static_cast<std::uint64_t>(i) * 3;
        const double target = (static_cast<double>(i) + uniform(seed, number)) /
                              static_cast<double>(num_samples) * total;
        while (covered < target && triangle + 1 < mesh.triangles.size())
            covered += types::triangle_area_m2(mesh, mesh.triangles[++triangle]);
        samples.push_back(point_in_triangle(
            mesh, mesh.triangles[triangle], uniform(seed, number + 1), uniform(seed, number + 2)));
    }
    return samples;
}

}  // namespace divemesh::evaluation
