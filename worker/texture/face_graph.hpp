#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "worker/types/mesh.hpp"

namespace divemesh::texture {

// A neighbour of a triangle.
struct FaceLink {
    std::uint32_t face = 0;
    std::uint32_t back = 0;  // index of the neighbour's link to this triangle
    float edge_m = 0.0F;     // length of the edge that they share
};

// The triangles that share an edge. The triangles of a non-manifold edge form a chain in their
// order, so that memory is linear however many they are.
class FaceGraph {
public:
    explicit FaceGraph(const types::Mesh& mesh);

    std::size_t num_faces() const { return begin_.size() - 1; }
    std::size_t num_links() const { return links_.size(); }
    std::span<const FaceLink> links(std::size_t face) const {
        return {links_.data() + begin_[face], begin_[face + 1] - begin_[face]};
    }
    // Returns the index of the first link of a triangle among the links of all.
    std::uint32_t first_link(std::size_t face) const { return begin_[face]; }

private:
    std::vector<std::uint32_t> begin_;
    std::vector<FaceLink> links_;
};

// Returns the triangles in groups without two neighbours in one (greedy colouring), so that a group
// can be worked on by several threads. A manifold mesh has at most four.
std::vector<std::vector<std::uint32_t>> independent_faces(const FaceGraph& graph);

}  // namespace divemesh::texture
