#pragma once

#include <Eigen/Core>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "worker/compare/point_grid.hpp"

namespace divemesh::compare {

// The vertices of a surface, with a grid that finds those near a line.
struct SurfacePoints {
    const std::vector<Eigen::Vector3f>& points;
    const std::vector<Eigen::Vector3f>& normals;  // unit, outward
    const std::vector<float>& sigma_m;            // of each point along its normal; empty: unknown
    const PointGrid& grid;                        // of `points`
    std::span<const float> spacing_m = {};        // of the points around each; empty: uniform
};

struct M3c2Options {
    float normal_scale_m = 0.1F;  // D: a core's normal is the mean of those within D / 2
    float cylinder_m = 0.05F;     // d: diameter
    float reach_m = 0.5F;         // of the cylinder to either side of the core
    float independent_m = 0.0F;   // points nearer to each other than this share their error
    // Least points of either surface in a cylinder; with fewer the distance is unknown.
    std::size_t min_points = 4;
    // Returns the 95 % bound of the co-registration's error along a direction at a point, m; empty:
    // no error.
    std::function<float(const Eigen::Vector3f& p, const Eigen::Vector3f& n)> registration95_m;
};

// The distance of two surfaces along a core's normal, positive if `b` lies outside `a`.
struct M3c2Distance {
    float distance_m = std::numeric_limits<float>::quiet_NaN();  // NaN: too few points
    float lod95_m = std::numeric_limits<float>::quiet_NaN();     // level of detection

    bool known() const { return distance_m == distance_m; }
    bool significant() const { return std::abs(distance_m) > lod95_m; }
};

// Computes M3C2 distances (Lague, Brodu and Leroux 2013). For each core the points of either
// surface within a cylinder along the normal are projected onto it. The distance is that of their
// means, and LoD95 = 1.96 sqrt(s1^2 / n1 + s2^2 / n2) + co-registration. s^2 is the larger of the
// spread about the mean and of the points' own variance (M3C2-EP, Winiwarter et al. 2021), n the
// number of independent points: at most the number of squares of `independent_m` in the cylinder's
// cross-section. If a surface lies in the cylinder in layers, only the layer nearest to the core
// counts, and only points that face the same way as the core. Cores are the points of `core`
// itself, which is a or b. Where the cylinder has too few points, because a surface is sampled more
// coarsely there, both scales grow to what the spacing of the coarser surface needs.
std::vector<M3c2Distance> m3c2_distances(const SurfacePoints& core,
                                         const SurfacePoints& a,
                                         const SurfacePoints& b,
                                         const M3c2Options& options,
                                         int num_threads);

}  // namespace divemesh::compare
