#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "worker/mesh/block_net.hpp"
#include "worker/mesh/block_surroundings.hpp"

namespace divemesh::mesh {

// The polygons of a surface net, each around a crossed edge. A polygon has a corner in each cell
// around its edge: a triangle where a coarser cell has the edge in its face.
struct BlockPolygons {
    std::vector<std::array<std::uint32_t, 4>> quads;
    std::vector<std::array<std::uint32_t, 3>> triangles;
};

// Dual contouring of an octree (Ju et al. 2002) for a block that others of another level touch. An
// edge is used by the finest of its cells, if none of those around it is finer.

// Finds the vertices in the block's cells. A cell that touches finer ones is crossed by their edges
// too.
void find_vertices_between_levels(const FieldReader& reader,
                                  const BlockSurroundings& here,
                                  BlockNet& net);

// Adds the polygons around the edges of a cell on the boundary of the block, where the cell is the
// one that adds them.
void add_polygons_between_levels(const FieldReader& reader,
                                 const BlockSurroundings& here,
                                 const std::vector<BlockNet>& nets,
                                 const ActiveCell& active,
                                 const Eigen::Vector3i& cell,
                                 BlockPolygons& polygons);

}  // namespace divemesh::mesh
