#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "worker/mesh/cell_topology.hpp"
#include "worker/mesh/crossed_cells.hpp"

namespace divemesh::mesh {

inline constexpr std::uint16_t kNoVertex = 0xffff;
inline constexpr std::uint32_t kNoIndex = 0xffffffffU;

// A cell that the surface passes through: its signs and its vertices, one per loop.
struct ActiveCell {
    std::uint16_t first_vertex = kNoVertex;  // in the block
    std::uint8_t mask = 0;
    std::uint8_t joined_face = kNoFace;  // or kRefined
};
// In place of a joined face: the cell has a RefinedTopology.
inline constexpr std::uint8_t kRefined = kNoFace + 1;

struct RefinedCell {
    std::uint16_t cell = 0;  // in the block
    std::array<std::int16_t, 81> loop_of_edge;
};

struct NetVertex {
    Eigen::Vector3i cell;
    Eigen::Vector3f crossing;  // mean of the cell's zeros, in the cell, 0 to 1
    std::array<float, 8> corners_m;
    std::int16_t level;
    bool single;  // the only sheet in its cell
};

// The vertices of the surface net in a block.
struct BlockNet {
    std::vector<ActiveCell> cells;  // 512, or empty if the surface does not pass through the block
    std::vector<RefinedCell> refined;  // sorted by cell
    std::vector<NetVertex> vertices;
    std::uint32_t first_vertex = 0;  // of the block in the mesh
    bool one_level = true;           // no block of another level touches it
};

// Returns the vertex of the mesh for an edge (of CellTopology) of a cell; kNoIndex if it has none.
std::uint32_t vertex_at(const BlockNet& net, int cell, int edge);
// The same for an edge of RefinedTopology.
std::uint32_t refined_vertex_at(const BlockNet& net, int cell, int edge);

// Adds a cell that touches no finer ones, and its vertices. `first_sample` is the block's.
void add_cell(BlockNet& net,
              int level,
              const Eigen::Vector3i& first_sample,
              const CrossedCell& cell,
              int joined_face);

}  // namespace divemesh::mesh
