#include "worker/mosaic/surface_color.hpp"

#include <algorithm>
#include <cmath>

#include "worker/base/bilinear.hpp"

namespace divemesh::mosaic {
namespace {

// Samples along a row or column of a pixel: twice the border of charts (texture/cut_charts), within
// which the atlas goes on beyond a triangle. On a wall a pixel covers any number of texels.
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

// Where samples lie between the edges of a pixel, along its row or column.
struct Samples {
    long count = 1;
    bool leave_border = false;  // of the chart: they may lie farther outside the triangle

    double offset(long sample) const {
        return (static_cast<double>(sample) + 0.5) / static_cast<double>(count) - 0.5;
    }
};

// Returns a sample for each texel that `step` covers.
Samples samples_along(const TexelCorners& corners, const Eigen::Vector3d& step) {
    const double num_texels = (corners * step).norm();
    const auto max = static_cast<double>(kMaxSamples);
    return {static_cast<long>(std::clamp(std::round(num_texels), 1.0, max)), num_texels > max};
}

// Returns the weights of the nearest place in the triangle, roughly: far outside of it the atlas
// shows something else.
Eigen::Vector3d moved_inside(const Eigen::Vector3d& weights) {
    const Eigen::Vector3d inside = weights.cwiseMax(0.0);
    return inside / inside.sum();
}

Eigen::Vector3f mean_texel(const cv::Mat& atlas,
                           const TexelCorners& corners,
                           const PixelFootprint& pixel) {
    const Samples columns = samples_along(corners, pixel.along_row);
    const Samples rows = samples_along(corners, pixel.along_column);
    const bool leave_border = columns.leave_border || rows.leave_border;
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (long row = 0; row < rows.count; ++row)
        for (long column = 0; column < columns.count; ++column) {
            const Eigen::Vector3d weights = pixel.weights +
                                            columns.offset(column) * pixel.along_row +
                                            rows.offset(row) * pixel.along_column;
            const Eigen::Vector2d place =
                corners * (leave_border ? moved_inside(weights) : weights);
            sum += base::bilinear_color(atlas, place.cast<float>());
        }
    return sum / static_cast<float>(rows.count * columns.count);
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
