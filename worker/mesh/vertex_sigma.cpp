#include "worker/mesh/vertex_sigma.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace divemesh::mesh {
namespace {

constexpr float kAlike = 0.05F;     // r
constexpr float kFlattened = 3.5F;  // c

// Returns for every vertex the mean, over the triangles around it, of their corners' values; the
// fourth component is the number of corners.
using Values = std::vector<Eigen::Vector4f>;
Values means_around(const types::Mesh& mesh, const Values& values) {
    Values sums(values.size(), Eigen::Vector4f::Zero());
    for (const auto& t : mesh.triangles) {
        const Eigen::Vector4f sum = values[t[0]] + values[t[1]] + values[t[2]];
        for (const std::uint32_t vertex : t) sums[vertex] += sum;
    }
    for (Eigen::Vector4f& sum : sums)
        if (sum.w() > 0.0F) sum /= sum.w();
    return sums;
}

}  // namespace

void finish_sigma(types::Mesh& mesh, double sigma_poses_m) {
    if (mesh.sigma_m.empty()) return;
    mesh.sigma_local_m.resize(mesh.sigma_m.size());
    Values normals;
    normals.reserve(mesh.normals.size());
    for (const Eigen::Vector3f& normal : mesh.normals) normals.emplace_back(normal.homogeneous());
    normals = means_around(mesh, means_around(mesh, normals));
    const auto poses_m2 = static_cast<float>(sigma_poses_m * sigma_poses_m);
    for (std::size_t i = 0; i < mesh.sigma_m.size(); ++i) {
        const float num_views =
            mesh.num_observations.empty() ? 1.0F : static_cast<float>(mesh.num_observations[i]);
        const float flattened_m = mesh.voxel_m.empty() ? 0.0F : kFlattened * mesh.voxel_m[i];
        const float alike = 1.0F + kAlike * std::max(0.0F, num_views - 1.0F);
        const float theta2 =
            normals.empty() ? 0.0F : 2.0F * std::max(0.0F, 1.0F - normals[i].head<3>().norm());
        mesh.sigma_local_m[i] = std::sqrt(alike) * mesh.sigma_m[i];
        mesh.sigma_m[i] = std::sqrt(mesh.sigma_local_m[i] * mesh.sigma_local_m[i] +
                                    flattened_m * flattened_m * theta2 + poses_m2);
    }
}

}  // namespace divemesh::mesh
