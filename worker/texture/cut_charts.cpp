#include "worker/texture/cut_charts.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <tuple>
#include <utility>

#include "worker/base/disjoint_sets.hpp"
#include "worker/base/pixels_around.hpp"
#include "worker/types/texture.hpp"

namespace divemesh::texture {
namespace {

cv::Rect bounds_of(const types::Mesh& mesh,
                   std::size_t triangle,
                   std::int32_t keyframe,
                   const Photographs& photographs) {
    std::array<Eigen::Vector2d, 3> corners;
    for (std::size_t k = 0; k < corners.size(); ++k)
        corners[k] =
            photographs.pixel(keyframe, mesh.vertices[mesh.triangles[triangle][k]]).value();
    return base::pixels_around(corners);
}

Cutouts one_per_chart(const types::Mesh& mesh,
                      const FaceViews& views,
                      const std::vector<SharedEdge>& edges,
                      const Photographs& photographs) {
    base::DisjointSets charts(mesh.triangles.size());
    for (const SharedEdge& edge : edges)
        if (views[edge.triangles[0]] == views[edge.triangles[1]])
            charts.join(edge.triangles[0], edge.triangles[1]);
    Cutouts cutouts;
    cutouts.of_triangle.assign(mesh.triangles.size(), Cutouts::kNone);
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        if (views[i] == kNoView) continue;
        const std::size_t first = charts.find(i);  // the lowest triangle of the chart
        if (first == i) {
            cutouts.of_triangle[i] = static_cast<std::int32_t>(cutouts.all.size());
            cutouts.all.push_back({views[i], {}});
        }
        cutouts.of_triangle[i] = cutouts.of_triangle[first];
        cv::Rect& pixels = cutouts.all[cutouts.of_triangle[i]].pixels;
        pixels |= bounds_of(mesh, i, views[i], photographs);  // OpenCV: of an empty one, the other
    }
    return cutouts;
}

// Returns the place of a pixel along the Z-order curve, on which neighbours are close to each other
// (Morton 1966).
std::uint32_t z_order(cv::Point pixel) {
    std::uint32_t order = 0;
    for (int bit = 0; bit < 16; ++bit)
        order |= (static_cast<std::uint32_t>(pixel.x >> bit) & 1U) << (2 * bit) |
                 (static_cast<std::uint32_t>(pixel.y >> bit) & 1U) << (2 * bit + 1);
    return order;
}

std::int64_t num_texels(const cv::Rect& pixels) {
    constexpr int kBorders_px = 2 * types::Texture::kBorder_px;
    return std::int64_t{pixels.width + kBorders_px} * (pixels.height + kBorders_px);
}

bool is_better_together(const Cutout& a, const Cutout& b) {
    return a.keyframe == b.keyframe &&
           num_texels(a.pixels | b.pixels) <= num_texels(a.pixels) + num_texels(b.pixels);
}

// Joins each cutout with one of the few before it along the curve, if that saves texels.
Cutouts join_neighbours(const Cutouts& cutouts) {
    constexpr std::size_t kNumTried = 16;
    std::vector<std::uint32_t> order(cutouts.all.size());
    std::iota(order.begin(), order.end(), 0U);
    const auto place = [&](std::uint32_t i) {
        const Cutout& cutout = cutouts.all[i];
        return std::tuple(
            cutout.keyframe, z_order((cutout.pixels.tl() + cutout.pixels.br()) / 2), i);
    };
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return place(a) < place(b);
    });
    Cutouts joined;
    std::vector<std::int32_t> renumbered(cutouts.all.size());
    for (const std::uint32_t i : order) {
        const std::size_t num = joined.all.size();
        std::size_t into = num;
        for (std::size_t k = 1; k <= std::min(kNumTried, num) && into == num; ++k)
            if (is_better_together(joined.all[num - k], cutouts.all[i])) into = num - k;
        if (into == num) joined.all.push_back(cutouts.all[i]);
        joined.all[into].pixels |= cutouts.all[i].pixels;
        renumbered[i] = static_cast<std::int32_t>(into);
    }
    joined.of_triangle.reserve(cutouts.of_triangle.size());
    for (const std::int32_t cutout : cutouts.of_triangle)
        joined.of_triangle.push_back(cutout == Cutouts::kNone ? cutout : renumbered[cutout]);
    return joined;
}

}  // namespace

Cutouts cut_charts(const types::Mesh& mesh,
                   const FaceViews& views,
                   const std::vector<SharedEdge>& edges,
                   const Photographs& photographs) {
    constexpr int kMaxRounds = 8;
    Cutouts cutouts = one_per_chart(mesh, views, edges, photographs);
    for (int round = 0; round < kMaxRounds; ++round) {
        const std::size_t num_before = cutouts.all.size();
        cutouts = join_neighbours(cutouts);
        if (cutouts.all.size() == num_before) break;
    }
    return cutouts;
}

}  // namespace divemesh::texture
