#include "worker/reef/surface_patch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "worker/io/mesh_check.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::reef {
namespace {

constexpr std::uint32_t kLeftOut = std::numeric_limits<std::uint32_t>::max();

using Box = Eigen::AlignedBox2d;

Box bounds_of(const Polygon& outline, double margin_m) {
    Box box;
    for (const Eigen::Vector2d& corner : outline) box.extend(corner);
    return {box.min().array() - margin_m, box.max().array() + margin_m};
}

// Returns whether the outline is an upright rectangle, so that parts within its bounds need no
// clipping.
bool fills(const Polygon& outline, const Box& bounds) {
    return outline.size() == 4 && area_m2(outline) > (1.0 - 1e-9) * bounds.volume();
}

double share_within(const Polygon& outline, const std::array<Eigen::Vector3d, 3>& corners) {
    const Eigen::Vector2d a = corners[0].head<2>();
    const Eigen::Vector2d ab = corners[1].head<2>() - a;
    const Eigen::Vector2d ac = corners[2].head<2>() - a;
    const double area = 0.5 * std::abs(ab.x() * ac.y() - ab.y() * ac.x());
    if (area > 1e-12) return std::min(1.0, overlap_m2(outline, a, a + ab, a + ac) / area);
    return contains(outline, a + (ab + ac) / 3.0) ? 1.0 : 0.0;  // edge-on
}

double triangle_area(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
    return 0.5 * (b - a).cross(c - a).norm();
}

double known_or_zero(const std::vector<float>& sigmas_m, std::uint32_t vertex) {
    const double sigma = sigmas_m.empty() ? 0.0 : sigmas_m[vertex];
    return std::isfinite(sigma) && sigma > 0.0 ? sigma : 0.0;
}

// Copies vertices into the patch as triangles need them.
class PatchBuilder {
public:
    PatchBuilder(const types::Mesh& mesh, const Eigen::Isometry3d& T_plane_world)
        : mesh_(mesh),
          normals_(io::unit_normals(mesh)),
          T_plane_world_(T_plane_world),
          index_(mesh.vertices.size(), kLeftOut) {}

    std::uint32_t index_of(std::uint32_t vertex) {
        if (index_[vertex] != kLeftOut) return index_[vertex];
        index_[vertex] = static_cast<std::uint32_t>(patch.vertices.size());
        patch.vertices.emplace_back(T_plane_world_ * mesh_.vertices[vertex].cast<double>());
        patch.normals.emplace_back(T_plane_world_.linear() * normals_[vertex].cast<double>());
        patch.sigma_m.push_back(known_or_zero(mesh_.sigma_m, vertex));
        patch.sigma_local_m.push_back(known_or_zero(
            mesh_.sigma_local_m.empty() ? mesh_.sigma_m : mesh_.sigma_local_m, vertex));
        return index_[vertex];
    }

    SurfacePatch patch;

private:
    const types::Mesh& mesh_;
    std::vector<Eigen::Vector3f> normals_;
    const Eigen::Isometry3d& T_plane_world_;
    std::vector<std::uint32_t> index_;
};

}  // namespace

SurfacePatch cut_patch(const types::Mesh& mesh, const AreaPlane& plane, double margin_m) {
    const Box bounds = bounds_of(plane.outline, margin_m);
    const Eigen::Matrix<float, 2, 3> rotation =
        plane.T_plane_world.linear().topRows<2>().cast<float>();
    const Eigen::Vector2f shift = plane.T_plane_world.translation().head<2>().cast<float>();
    std::vector<Eigen::Vector2f> places;
    places.reserve(mesh.vertices.size());
    for (const Eigen::Vector3f& vertex : mesh.vertices)
        places.emplace_back(rotation * vertex + shift);
    const Eigen::AlignedBox2f near(bounds.min().cast<float>(), bounds.max().cast<float>());
    const Box tight = bounds_of(plane.outline, 0.0);
    const bool is_rectangle = fills(plane.outline, tight);
    const Eigen::AlignedBox2f inner(tight.min().cast<float>(), tight.max().cast<float>());
    PatchBuilder builder(mesh, plane.T_plane_world);
    SurfacePatch& patch = builder.patch;
    for (const auto& [a, b, c] : mesh.triangles) {
        Eigen::AlignedBox2f box(places[a]);
        box.extend(places[b]).extend(places[c]);
        if (!near.intersects(box)) continue;
        patch.triangles.push_back({builder.index_of(a), builder.index_of(b), builder.index_of(c)});
        if (is_rectangle && inner.contains(box)) {
            patch.share_within.push_back(1.0);
            continue;
        }
        if (plane.outline.size() < 3) {  // a transect's line: all of the mesh near it
            patch.share_within.push_back(1.0);
            continue;
        }
        const auto& corners = patch.triangles.back();
        patch.share_within.push_back(share_within(
            plane.outline,
            {patch.vertices[corners[0]], patch.vertices[corners[1]], patch.vertices[corners[2]]}));
    }
    return std::move(builder.patch);
}

double surface_area_m2(const SurfacePatch& patch, const std::vector<Eigen::Vector3d>& vertices) {
    double area = 0.0;
    for (std::size_t i = 0; i < patch.triangles.size(); ++i) {
        if (patch.share_within[i] <= 0.0) continue;
        const auto& [a, b, c] = patch.triangles[i];
        area += patch.share_within[i] * triangle_area(vertices[a], vertices[b], vertices[c]);
    }
    return area;
}

std::optional<double> typical_sigma_m(const std::vector<double>& sigma_m) {
    double squares = 0.0;
    std::size_t num = 0;
    for (const double sigma : sigma_m) {
        if (sigma <= 0.0) continue;
        squares += sigma * sigma;
        ++num;
    }
    if (num == 0) return std::nullopt;
    return std::sqrt(squares / static_cast<double>(num));
}

std::optional<double> sigma_of_most_m(const SurfacePatch& patch,
                                      const std::vector<double>& sigma_m) {
    constexpr double kMost = 0.8;
    std::vector<std::pair<double, double>> parts;  // sigma, m, and area, m2
    double total = 0.0;
    for (std::size_t i = 0; i < patch.triangles.size(); ++i) {
        const auto& [a, b, c] = patch.triangles[i];
        const double sigma = (sigma_m[a] + sigma_m[b] + sigma_m[c]) / 3.0;
        if (sigma <= 0.0 || patch.share_within[i] <= 0.0) continue;
        parts.emplace_back(
            sigma,
            patch.share_within[i] *
                triangle_area(patch.vertices[a], patch.vertices[b], patch.vertices[c]));
        total += parts.back().second;
    }
    if (parts.empty()) return std::nullopt;
    std::sort(parts.begin(), parts.end());
    std::size_t i = 0;
    for (double area = parts[0].second; area < kMost * total && i + 1 < parts.size();)
        area += parts[++i].second;
    return parts[i].first;
}

std::optional<double> median_range_m(const SurfacePatch& patch,
                                     const std::vector<Eigen::Vector3d>& cameras_plane) {
    if (patch.vertices.empty() || cameras_plane.empty()) return std::nullopt;
    constexpr std::size_t kMaxVertices = 500;
    const std::size_t step = patch.vertices.size() / kMaxVertices + 1;
    std::vector<double> ranges;
    for (std::size_t i = 0; i < patch.vertices.size(); i += step) {
        double nearest = std::numeric_limits<double>::infinity();
        for (const Eigen::Vector3d& camera : cameras_plane)
            nearest = std::min(nearest, (camera - patch.vertices[i]).squaredNorm());
        ranges.push_back(std::sqrt(nearest));
    }
    return stats::upper_median(std::move(ranges));
}

double median_edge_m(const SurfacePatch& patch) {
    if (patch.triangles.empty()) return 0.0;
    std::vector<double> lengths;
    for (const auto& [a, b, c] : patch.triangles)
        for (const auto& [from, to] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)})
            lengths.push_back((patch.vertices[from] - patch.vertices[to]).norm());
    return stats::upper_median(std::move(lengths));
}

}  // namespace divemesh::reef
