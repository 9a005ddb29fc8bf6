#include "worker/mosaic/texel_size.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "worker/mesh/mean_edge.hpp"

namespace divemesh::mosaic {
namespace {

constexpr double kMinPixel_m = 5e-4;
constexpr double kMaxPixel_m = 2e-3;
constexpr double kStep_m = 1e-4;
constexpr double kMinUp = 0.7;  // z of the normal: within 45 degrees of the horizontal

// The size of a triangle's texels and what it adds to the median.
struct TexelSize {
    double size_m = 0.0;
    double area_m2 = 0.0;
};

double texels_of(const types::Texture& texture, std::size_t triangle) {
    const cv::Mat& atlas =
        texture.atlases[static_cast<std::size_t>(texture.atlas_of_triangle[triangle])];
    const auto& [a, b, c] = texture.uv[triangle];
    const Eigen::Vector2d ab = (b - a).cast<double>();
    const Eigen::Vector2d ac = (c - a).cast<double>();
    return 0.5 * std::abs(ab.x() * ac.y() - ab.y() * ac.x()) * static_cast<double>(atlas.cols) *
           static_cast<double>(atlas.rows);
}

std::vector<TexelSize> sizes_upwards(const types::Mesh& mesh, const types::Texture& texture) {
    std::vector<TexelSize> sizes;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        if (texture.atlas_of_triangle[i] == types::Texture::kUntextured) continue;
        const auto& [a, b, c] = mesh.triangles[i];
        const Eigen::Vector3d normal =
            0.5 * (mesh.vertices[b] - mesh.vertices[a])
                      .cast<double>()
                      .cross((mesh.vertices[c] - mesh.vertices[a]).cast<double>());
        const double area_m2 = normal.norm();
        const double num_texels = texels_of(texture, i);
        if (normal.z() <= kMinUp * area_m2 || num_texels <= 0.0) continue;
        sizes.push_back({std::sqrt(area_m2 / num_texels), area_m2});
    }
    return sizes;
}

double median_by_area_m(std::vector<TexelSize> sizes) {
    std::sort(sizes.begin(), sizes.end(), [](const TexelSize& one, const TexelSize& other) {
        return std::pair(one.size_m, one.area_m2) < std::pair(other.size_m, other.area_m2);
    });
    double left_m2 = 0.0;
    for (const TexelSize& size : sizes) left_m2 += 0.5 * size.area_m2;
    for (const TexelSize& size : sizes) {
        left_m2 -= size.area_m2;
        if (left_m2 <= 0.0) return size.size_m;
    }
    return 0.0;
}

}  // namespace

double seen_pixel_m(const types::Mesh& mesh, const types::Texture& texture) {
    const std::vector<TexelSize> sizes = sizes_upwards(mesh, texture);
    const double size_m = sizes.empty() ? 0.5 * mesh::mean_edge_m(mesh) : median_by_area_m(sizes);
    return std::clamp(std::round(size_m / kStep_m) * kStep_m, kMinPixel_m, kMaxPixel_m);
}

}  // namespace divemesh::mosaic
