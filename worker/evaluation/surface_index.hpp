#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "worker/base/parallel.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::evaluation {

// Finds the nearest point and the first hit on a triangle mesh, by Embree. Keeps a reference to the
// mesh, which must not change during its lifetime. Thread-safe after construction.
class SurfaceIndex {
public:
    // `is_compact`: about half the memory, somewhat slower.
    explicit SurfaceIndex(const types::Mesh& mesh, bool is_compact = false);
    ~SurfaceIndex();
    SurfaceIndex(const SurfaceIndex&) = delete;
    SurfaceIndex& operator=(const SurfaceIndex&) = delete;

    // Returns the distance to the nearest point of any triangle; `max_m` if it is farther, or if
    // the mesh has no triangles.
    float distance_m(const Eigen::Vector3f& point,
                     float max_m = std::numeric_limits<float>::infinity()) const;

    // Returns the distances of points. Fast where points that follow each other are neighbours.
    std::vector<double> distances_m(const std::vector<Eigen::Vector3f>& points,
                                    int num_threads,
                                    const base::ProgressShare& progress = {}) const;

    // Returns the distance along a unit direction to the first triangle, from either side; nullopt
    // if there is no hit.
    std::optional<float> first_hit_m(const Eigen::Vector3f& origin,
                                     const Eigen::Vector3f& direction) const;

private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

// Finds the distance to the nearest point of a cloud, whose vertices are indexed as degenerate
// triangles.
class PointIndex {
public:
    explicit PointIndex(const types::Mesh& cloud);

    float distance_m(const Eigen::Vector3f& point,
                     float max_m = std::numeric_limits<float>::infinity()) const {
        return index_.distance_m(point, max_m);
    }
    std::vector<double> distances_m(const std::vector<Eigen::Vector3f>& points,
                                    int num_threads) const {
        return index_.distances_m(points, num_threads);
    }

private:
    types::Mesh points_;
    SurfaceIndex index_;
};

// Returns the squared distance to the nearest point of triangle abc (Ericson 2005, 5.1.5).
float squared_distance_to_triangle(const Eigen::Vector3f& point,
                                   const Eigen::Vector3f& a,
                                   const Eigen::Vector3f& b,
                                   const Eigen::Vector3f& c);

}  // namespace divemesh::evaluation
