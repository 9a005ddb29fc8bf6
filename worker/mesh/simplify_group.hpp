#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "worker/types/mesh.hpp"

namespace divemesh::mesh {

// Triangles of a mesh that are simplified together, while their common border stays.
struct SimplifiedGroup {
    std::vector<std::array<std::uint32_t, 3>> triangles;
    // Edges, lower vertex first. Every edge that could also be one of another group is listed.
    std::vector<std::array<std::uint32_t, 2>> border;  // of only one triangle
    std::vector<std::array<std::uint32_t, 2>> chords;  // between vertices of the border, inside
};

// Returns the triangles with edges collapsed by meshoptimizer up to a quadric error; with an error
// of 0 they remain as they are. Returns nullopt if the collapses gave an edge more than two
// triangles.
std::optional<SimplifiedGroup> simplify_group(
    const std::vector<Eigen::Vector3f>& vertices,
    const std::vector<std::array<std::uint32_t, 3>>& triangles,
    double max_error_m);

// Returns the triangles with edges collapsed in the same way, for display: an edge may get more
// than two triangles.
std::vector<std::array<std::uint32_t, 3>> collapse_within_border(
    const std::vector<Eigen::Vector3f>& vertices,
    const std::vector<std::array<std::uint32_t, 3>>& triangles,
    double max_error_m);

}  // namespace divemesh::mesh
