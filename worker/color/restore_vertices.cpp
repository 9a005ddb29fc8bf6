#include "worker/color/restore_vertices.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <stdexcept>
#include <utility>

#include "worker/mesh/fill_colors.hpp"
#include "worker/stats/ratio.hpp"

namespace divemesh::color {
namespace {

constexpr std::size_t kVerticesOfBlock = 1024;  // as many as triangles in a run
constexpr int kWindow_px = 3;                   // of the mean: vertices are a few pixels apart

// Consecutive vertices, which lie close to each other, with a sphere around them.
struct VertexBlock {
    std::size_t begin = 0;
    std::size_t end = 0;
    mesh::TriangleRun sphere;
};

std::vector<VertexBlock> blocks_of(const types::Mesh& mesh) {
    std::vector<VertexBlock> blocks;
    for (std::size_t begin = 0; begin < mesh.vertices.size(); begin += kVerticesOfBlock) {
        const std::size_t end = std::min(mesh.vertices.size(), begin + kVerticesOfBlock);
        Eigen::AlignedBox3f box;
        for (std::size_t i = begin; i < end; ++i) box.extend(mesh.vertices[i]);
        blocks.push_back({begin, end, {0, 0, box.center(), 0.5F * box.diagonal().norm()}});
    }
    return blocks;
}

// The weighted sum of a vertex's colours.
struct ColorSum {
    std::array<float, 3> rgb = {};
    float weight = 0.0F;
    std::uint32_t num = 0;
    std::uint32_t num_limited = 0;

    void add(const RestoredColor& color) {
        const float w = 1.0F / (color.amplification * color.amplification);
        for (std::size_t c = 0; c < 3; ++c) rgb[c] += w * color.rgb[c];
        weight += w;
        ++num;
        num_limited += color.is_limited ? 1U : 0U;
    }
};

std::vector<ColorSum> sums_of(const SeenSurface& surface,
                              const std::vector<types::Keyframe>& keyframes,
                              const ReadKeyframe& read,
                              const Restorer& restorer,
                              int num_threads,
                              const base::ProgressShare& progress) {
    const types::Mesh& mesh = surface.mesh;
    const std::vector<VertexBlock> blocks = blocks_of(mesh);
    std::vector<ColorSum> sums(mesh.vertices.size());
    for_each_view(
        surface,
        keyframes,
        read,
        num_threads,
        progress,
        [&](std::size_t keyframe, const KeyframeView& view) {
            const mesh::ImageCamera camera = surface.camera_of(keyframes[keyframe]);
            base::for_each_index(num_threads, blocks.size(), [&](std::size_t block) {
                if (!camera.may_see(blocks[block].sphere)) return;
                for (std::size_t i = blocks[block].begin; i < blocks[block].end; ++i) {
                    const auto seen = view.seen_at(mesh.vertices[i], mesh.normals[i], kWindow_px);
                    if (!seen) continue;
                    sums[i].add(restorer.restore(
                        {seen->rgb, seen->range_m, seen->eccentricity, seen->cosine}, keyframe));
                }
            });
        });
    return sums;
}

}  // namespace

RestoredVertices restore_vertices(const SeenSurface& surface,
                                  const std::vector<types::Keyframe>& keyframes,
                                  const ReadKeyframe& read,
                                  const Restorer& restorer,
                                  int num_threads,
                                  const base::ProgressShare& progress) {
    if (surface.mesh.normals.size() != surface.mesh.vertices.size())
        throw std::logic_error("colours of vertices are restored by their normals");
    const std::vector<ColorSum> sums =
        sums_of(surface, keyframes, read, restorer, num_threads, progress);
    types::Mesh colored;
    colored.triangles = surface.mesh.triangles;
    colored.colors = surface.mesh.colors;
    colored.colors.resize(sums.size());
    std::vector<std::uint8_t> has_color(sums.size(), 0);
    double num = 0.0;
    double num_limited = 0.0;
    for (std::size_t i = 0; i < sums.size(); ++i) {
        num += sums[i].num;
        num_limited += sums[i].num_limited;
        if (sums[i].num == 0) continue;
        has_color[i] = 1;
        for (std::size_t c = 0; c < 3; ++c)
            colored.colors[i][c] = level_of(sums[i].rgb[c] / sums[i].weight);
    }
    mesh::fill_colors(colored, std::move(has_color));
    return {std::move(colored.colors), stats::ratio(num_limited, num)};
}

}  // namespace divemesh::color
