#include "worker/compare/m3c2.hpp"

#include <numbers>

#include "worker/base/parallel.hpp"
#include "worker/stats/distributions.hpp"

namespace divemesh::compare {
namespace {

constexpr std::size_t kSlice = 4096;  // cores per task
constexpr float kSpacings = 4.0F;     // of points that a cylinder's diameter spans on coarse ground
constexpr float kMaxGrowth = 8.0F;    // of the scales: three levels of voxels

struct Layer {
    std::size_t num = 0;
    double mean_m = 0.0;       // along the normal, from the core
    double variance_m2 = 0.0;  // of one point
};

struct Along {
    double place_m;
    double sigma_m;
};

Eigen::Vector3f mean_normal(const SurfacePoints& surface, std::size_t core, float scale_m) {
    const Eigen::Vector3f& p = surface.points[core];
    const float radius_squared = 0.25F * scale_m * scale_m;
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    surface.grid.near_segment(p, p, 0.5F * scale_m, [&](std::uint32_t i) {
        if ((surface.points[i] - p).squaredNorm() <= radius_squared) sum += surface.normals[i];
    });
    return sum.norm() > 0.0F ? Eigen::Vector3f(sum.normalized()) : surface.normals[core];
}

// Returns the mean of the points within half a width of the layer's estimated position, iterated
// twice.
Layer layer_about(const std::vector<Along>& points, double place_m, double half_width_m) {
    Layer layer;
    for (int round = 0; round < 2; ++round) {
        layer = {};
        double sum = 0.0;
        double squares = 0.0;
        double variances = 0.0;
        for (const auto& [along, sigma] : points) {
            const double from = along - place_m;
            if (std::abs(from) > half_width_m) continue;
            ++layer.num;
            sum += from;
            squares += from * from;
            variances += sigma * sigma;
        }
        if (layer.num == 0) return layer;
        const auto num = static_cast<double>(layer.num);
        const double mean = sum / num;
        layer.mean_m = place_m + mean;
        const double spread = layer.num > 1 ? (squares - num * mean * mean) / (num - 1.0) : 0.0;
        layer.variance_m2 = std::max(spread, variances / num);
        place_m = layer.mean_m;
    }
    return layer;
}

struct Cylinder {
    Eigen::Vector3f p;  // of the core
    Eigen::Vector3f normal;
    float diameter_m;
    float reach_m;  // to either side of the core
};

Layer layer_of(const SurfacePoints& surface, const Cylinder& cylinder, std::vector<Along>& points) {
    const float radius = 0.5F * cylinder.diameter_m;
    const Eigen::Vector3f to_end = cylinder.reach_m * cylinder.normal;
    points.clear();
    double nearest = std::numeric_limits<double>::infinity();
    surface.grid.near_segment(
        cylinder.p - to_end, cylinder.p + to_end, radius, [&](std::uint32_t i) {
            const Eigen::Vector3f from = surface.points[i] - cylinder.p;
            const float along = from.dot(cylinder.normal);
            if (std::abs(along) > cylinder.reach_m ||
                from.squaredNorm() - along * along > radius * radius ||
                surface.normals[i].dot(cylinder.normal) <= 0.0F)
                return;
            const float sigma = surface.sigma_m.empty() ? 0.0F : surface.sigma_m[i];
            points.push_back({static_cast<double>(along), static_cast<double>(sigma)});
            if (std::abs(points.back().place_m) < std::abs(nearest))
                nearest = points.back().place_m;
        });
    if (points.empty()) return {};
    return layer_about(points, nearest, static_cast<double>(cylinder.diameter_m));
}

double num_independent(std::size_t num, const M3c2Options& options) {
    const auto points = static_cast<double>(num);
    if (options.independent_m <= 0.0F) return points;
    const auto ratio = static_cast<double>(options.cylinder_m / options.independent_m);
    return std::min(points, std::max(1.0, 0.25 * std::numbers::pi * ratio * ratio));
}

// Returns the spacing of a surface's points near p; 0 if it is unknown or the surface is farther
// away.
float spacing_near(const SurfacePoints& surface, const Eigen::Vector3f& p, float reach_m) {
    if (surface.spacing_m.empty()) return 0.0F;
    const auto nearest = surface.grid.nearest(p, reach_m);
    return nearest ? surface.spacing_m[*nearest] : 0.0F;
}

class Measurer {
public:
    Measurer(const SurfacePoints& core,
             const SurfacePoints& a,
             const SurfacePoints& b,
             const M3c2Options& options)
        : core_(core), a_(a), b_(b), options_(options) {}

    // Measures the distance at a core with the stated scales, or, if these have too few points,
    // with larger ones.
    M3c2Distance measure(std::size_t i) {
        const M3c2Distance distance = measure(i, 1.0F);
        if (distance.known()) return distance;
        const float growth = growth_at(core_.points[i]);
        return growth > 1.0F ? measure(i, growth) : distance;
    }

private:
    // Returns how much larger the cylinder must be for the coarser surface.
    float growth_at(const Eigen::Vector3f& p) const {
        const float spacing_m =
            std::max(spacing_near(a_, p, options_.reach_m), spacing_near(b_, p, options_.reach_m));
        return std::min(kMaxGrowth, kSpacings * spacing_m / options_.cylinder_m);
    }

    M3c2Distance measure(std::size_t i, float growth) {
        const Eigen::Vector3f& p = core_.points[i];
        const Eigen::Vector3f normal = mean_normal(core_, i, growth * options_.normal_scale_m);
        const Cylinder cylinder{p, normal, growth * options_.cylinder_m, options_.reach_m};
        const Layer of_a = layer_of(a_, cylinder, points_);
        if (of_a.num < options_.min_points) return {};
        const Layer of_b = layer_of(b_, cylinder, points_);
        if (of_b.num < options_.min_points) return {};
        const double variance = of_a.variance_m2 / num_independent(of_a.num, options_) +
                                of_b.variance_m2 / num_independent(of_b.num, options_);
        return {static_cast<float>(of_b.mean_m - of_a.mean_m),
                static_cast<float>(stats::kNormal975 * std::sqrt(variance)) +
                    (options_.registration95_m ? options_.registration95_m(p, normal) : 0.0F)};
    }

    const SurfacePoints& core_;
    const SurfacePoints& a_;
    const SurfacePoints& b_;
    const M3c2Options& options_;
    std::vector<Along> points_;
};

}  // namespace

std::vector<M3c2Distance> m3c2_distances(const SurfacePoints& core,
                                         const SurfacePoints& a,
                                         const SurfacePoints& b,
                                         const M3c2Options& options,
                                         int num_threads) {
    std::vector<M3c2Distance> distances(core.points.size());
    // Neighbours follow each other, so that their surroundings are in the cache.
    const std::vector<std::uint32_t>& order = core.grid.in_order();
    base::for_each_index(num_threads, (order.size() + kSlice - 1) / kSlice, [&](std::size_t slice) {
        Measurer measurer(core, a, b, options);
        for (std::size_t k = slice * kSlice; k < std::min(order.size(), (slice + 1) * kSlice); ++k)
            distances[order[k]] = measurer.measure(order[k]);
    });
    return distances;
}

}  // namespace divemesh::compare
