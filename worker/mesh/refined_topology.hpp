#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace divemesh::mesh {

// How the surface passes through a cell that touches cells of half its size. They split some of its
// faces into four and some of its edges in two. Nodes are the corners of all these: node x + 3 y +
// 9 z is half an edge times (x, y, z) from the cell's first corner. Edge 3 n + a runs from node n
// along axis a to the next node. Part 4 f + q is quarter q of face f (of CellTopology), or the
// whole of a face that is not split for q = 0.
//
// The field at a node in the middle of an edge or a face is the mean of the corners. As in
// CellTopology there is one loop for each sheet of the surface, and corners behind it are kept
// apart where a part of a face is ambiguous. So both cells of each part agree.
struct RefinedTopology {
    struct Loop {
        Eigen::Vector3f crossing =
            Eigen::Vector3f::Zero();  // mean of its zeros, in the cell, 0 to 1
        int num_edges = 0;
    };
    std::array<std::int16_t, 81> loop_of_edge;  // -1: not crossed
    std::vector<Loop> loops;
    std::uint32_t folded_parts = 0;  // ambiguous ones that one loop crosses twice (bit: part)
};

// Returns the topology of a cell. Bit n of `split_nodes`: node n, in the middle of an edge or a
// face, splits it. In `joined_parts` (bit: part) the corners behind are joined instead of kept
// apart.
RefinedTopology refined_topology(const std::array<float, 8>& corners_m,
                                 std::uint32_t split_nodes,
                                 std::uint32_t joined_parts = 0);

inline int refined_edge(const Eigen::Vector3i& node, int axis) {
    return 3 * (node.x() + 3 * node.y() + 9 * node.z()) + axis;
}

// Returns the nodes that split a cell whose neighbour at `offset` (-1 to 1) has half its size.
std::uint32_t nodes_towards(const Eigen::Vector3i& offset);

// Returns whether a face is split.
bool is_split(std::uint32_t split_nodes, int face);

// Returns the cell of half the size, of the next finer level, that lies behind a quarter of a face
// of `cell`.
Eigen::Vector3i cell_behind(const Eigen::Vector3i& cell, int part);

// Returns the part of a coarser cell's face that a cell shares with it.
int part_of_coarser(const Eigen::Vector3i& cell, int face_of_coarser);

}  // namespace divemesh::mesh
