#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "worker/types/mesh.hpp"
#include "worker/types/texture.hpp"

namespace divemesh::mosaic {

// A mesh of rectangles that face upwards, each with a colour or a part of an atlas.
struct Plates {
    types::Mesh mesh;
    types::Texture texture;

    // Adds a rectangle at height `z`, tilted so that it rises by `rise` per metre along x.
    void add(const Eigen::Vector2f& low,
             const Eigen::Vector2f& high,
             float z,
             const types::Color& color,
             float rise = 0.0F) {
        const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
        const auto height = [&](float x) { return z + rise * (x - low.x()); };
        mesh.vertices.insert(mesh.vertices.end(),
                             {{low.x(), low.y(), height(low.x())},
                              {high.x(), low.y(), height(high.x())},
                              {high.x(), high.y(), height(high.x())},
                              {low.x(), high.y(), height(low.x())}});
        mesh.colors.insert(mesh.colors.end(), 4, color);
        mesh.triangles.push_back({first, first + 1, first + 2});
        mesh.triangles.push_back({first, first + 2, first + 3});
        texture.atlas_of_triangle.insert(
            texture.atlas_of_triangle.end(), 2, types::Texture::kUntextured);
        texture.uv.resize(mesh.triangles.size());
    }

    // Gives the last rectangle a whole atlas, whose row 0 is north.
    void paint(const cv::Mat& atlas) {
        const auto index = static_cast<std::int32_t>(texture.atlases.size());
        texture.atlases.push_back(atlas);
        const std::size_t last = mesh.triangles.size() - 1;
        const Eigen::Vector2f south_west(0, 1);
        const Eigen::Vector2f north_east(1, 0);
        texture.uv[last - 1] = {south_west, Eigen::Vector2f(1, 1), north_east};
        texture.uv[last] = {south_west, north_east, Eigen::Vector2f(0, 0)};
        texture.atlas_of_triangle[last - 1] = index;
        texture.atlas_of_triangle[last] = index;
    }
};

}  // namespace divemesh::mosaic
