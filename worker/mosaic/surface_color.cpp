#include "worker/mosaic/surface_color.hpp"

#include <algorithm>
#include <cmath>

#include "worker/texture/bilinear.hpp"

namespace divemesh::mosaic {
namespace {

// Samples along a row or column of a pixel: on a wall, which a mosaic hardly shows, a pixel covers
// any number of texels.
constexpr long kMaxSamples = 8;

Eigen::Vector3f vertex_color(const types::Mesh& mesh, std::uint32_t vertex) {
    if (!mesh.colors.empty()) {
        const types::Color& color = mesh.colors[vertex];
        return {static_cast<float>(color[2]),
                static_cast<float>(color[1]),
                static_cast<float>(color[0])};
    }
    const float light = mesh.normals.empty() ? 0.7F : std::abs(mesh.normals[vertex].z());
    return Eigen::Vector3f::Constant(60.0F + 180.0F * light);
}

Eigen::Vector3f color_of_vertices(const types::Mesh& mesh,
                                  std::size_t triangle,
                                  const Eigen::Vector3d& weights) {
    Eigen::Vector3f color = Eigen::Vector3f::Zero();
    for (std::size_t i = 0; i < 3; ++i)
        color += static_cast<float>(weights[static_cast<Eigen::Index>(i)]) *
                 vertex_color(mesh, mesh.triangles[triangle][i]);
    return color;
}

// Returns the weights of the nearest place in the triangle, roughly: beyond it the atlas shows
// something else.
Eigen::Vector3d moved_inside(const Eigen::Vector3d& weights) {
    const Eigen::Vector3d inside = weights.cwiseMax(0.0);
    return inside / inside.sum();
}

// The corners of a triangle in its atlas, in texels with their centres at integers.
using TexelCorners = Eigen::Matrix<double, 2, 3>;

TexelCorners texel_corners(const std::array<Eigen::Vector2f, 3>& uv, const cv::Mat& atlas) {
    TexelCorners corners;
    for (std::size_t i = 0; i < 3; ++i)
        corners.col(static_cast<Eigen::Index>(i)) =
            uv[i].cast<double>().cwiseProduct(Eigen::Vector2d(atlas.cols, atlas.rows)) -
            Eigen::Vector2d(0.5, 0.5);
    return corners;
}

long num_samples(const TexelCorners& corners, const Eigen::Vector3d& step) {
    return static_cast<long>(
        std::clamp(std::round((corners * step).norm()), 1.0, static_cast<double>(kMaxSamples)));
}

Eigen::Vector3f mean_texel(const cv::Mat& atlas,
                           const TexelCorners& corners,
                           const PixelFootprint& pixel) {
    const long columns = num_samples(corners, pixel.along_row);
    const long rows = num_samples(corners, pixel.along_column);
    const auto offset = [](long sample, long count) {
        return (static_cast<double>(sample) + 0.5) / static_cast<double>(count) - 0.5;
    };
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (long row = 0; row < rows; ++row)
        for (long column = 0; column < columns; ++column) {
            const Eigen::Vector3d weights =
                moved_inside(pixel.weights + offset(column, columns) * pixel.along_row +
                             offset(row, rows) * pixel.along_column);
            const Eigen::Vector2f place = (corners * weights).cast<float>();
            sum += texture::bilinear_color(atlas, place);
        }
    return sum / static_cast<float>(rows * columns);
}

}  // namespace

Eigen::Vector3f surface_color(const types::Mesh& mesh,
                              const types::Texture* texture,
                              std::size_t triangle,
                              const PixelFootprint& pixel) {
    const std::int32_t atlas_index =
        texture == nullptr ? types::Texture::kUntextured : texture->atlas_of_triangle[triangle];
    if (atlas_index == types::Texture::kUntextured)
        return color_of_vertices(mesh, triangle, pixel.weights);
    const cv::Mat& atlas = texture->atlases[static_cast<std::size_t>(atlas_index)];
    return mean_texel(atlas, texel_corners(texture->uv[triangle], atlas), pixel);
}

}  // namespace divemesh::mosaic
