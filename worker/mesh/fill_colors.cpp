#include "worker/mesh/fill_colors.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>

namespace divemesh::mesh {
namespace {

// The colours of the coloured neighbours of a vertex.
struct ColorSum {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double num = 0.0;
};

using Triangle = std::array<std::uint32_t, 3>;

bool is_colored(const Triangle& triangle, const std::vector<std::uint8_t>& has_color) {
    return std::all_of(triangle.begin(), triangle.end(), [&](std::uint32_t vertex) {
        return has_color[vertex] != 0;
    });
}

std::map<std::uint32_t, ColorSum> sums_of_neighbours(const types::Mesh& mesh,
                                                     const std::vector<Triangle>& open,
                                                     const std::vector<std::uint8_t>& has_color) {
    std::map<std::uint32_t, ColorSum> sums;
    for (const Triangle& triangle : open)
        for (const std::uint32_t vertex : triangle)
            for (const std::uint32_t other : triangle) {
                if (has_color[vertex] != 0 || has_color[other] == 0) continue;
                const types::Color& color = mesh.colors[other];
                sums[vertex].sum += Eigen::Vector3d(color[0], color[1], color[2]);
                sums[vertex].num += 1.0;
            }
    return sums;
}

}  // namespace

void fill_colors(types::Mesh& mesh, std::vector<std::uint8_t> has_color) {
    std::vector<Triangle> open;
    for (const Triangle& triangle : mesh.triangles)
        if (!is_colored(triangle, has_color)) open.push_back(triangle);
    for (auto sums = sums_of_neighbours(mesh, open, has_color); !sums.empty();
         sums = sums_of_neighbours(mesh, open, has_color)) {
        for (const auto& [vertex, color] : sums) {
            for (int channel = 0; channel < 3; ++channel)
                mesh.colors[vertex][channel] =
                    static_cast<std::uint8_t>(std::lround(color.sum[channel] / color.num));
            has_color[vertex] = 1;
        }
        std::erase_if(open,
                      [&](const Triangle& triangle) { return is_colored(triangle, has_color); });
    }
}

}  // namespace divemesh::mesh
