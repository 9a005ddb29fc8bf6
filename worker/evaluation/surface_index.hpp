#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>

#include "worker/types/mesh.hpp"

namespace divemesh::evaluation {

// Nearest point and first hit on a triangle mesh, by Embree. Keeps the mesh, which may not change
// while this lives. Thread-safe after construction.
class SurfaceIndex {
public:
    // `is_compact`: about half the memory, somewhat slower.
    explicit SurfaceIndex(const types::Mesh& mesh, bool is_compact = false);
    ~SurfaceIndex();
    SurfaceIndex(const SurfaceIndex&) = delete;
    SurfaceIndex& operator=(const SurfaceIndex&) = delete;

    // To the nearest point of any triangle; infinity for a mesh without triangles.
    float distance_m(const Eigen::Vector3f& point) const;

    // Along a unit direction to the first triangle it meets, either side; nothing when none.
    std::optional<float> first_hit_m(const Eigen::Vector3f& origin,
                                     const Eigen::Vector3f& direction) const;

private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

// Nearest point of a cloud: its vertices as triangles without extent.
class PointIndex {
public:
    explicit PointIndex(const types::Mesh& cloud);

    float distance_m(const Eigen::Vector3f& point) const { return index_.distance_m(point); }

private:
    types::Mesh points_;
    SurfaceIndex index_;
};

// Squared distance to the nearest point of triangle abc (Ericson 2005, 5.1.5).
float squared_distance_to_triangle(const Eigen::Vector3f& point,
                                   const Eigen::Vector3f& a,
                                   const Eigen::Vector3f& b,
                                   const Eigen::Vector3f& c);

}  // namespace divemesh::evaluation
