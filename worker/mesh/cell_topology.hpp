#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace divemesh::mesh {

// How the surface passes through a cell, by the signs at its corners. Corner c lies at (c & 1, c >>
// 1 & 1, c >> 2 & 1). Edge 4 a + b + 2 c runs along axis a from the corner with coordinate b on
// axis (a + 1) % 3 and c on axis (a + 2) % 3. Face 2 a + s is normal to axis a at coordinate s.
//
// The surface crosses the faces of the cell in segments, which join to loops around the cell, one
// per sheet of the surface. A face with two opposite corners behind the surface is ambiguous: those
// corners are kept apart in both cells of the face, so that neighbours always agree.
struct CellTopology {
    std::array<std::int16_t, 12> loop_of_edge;  // -1: not crossed
    // Edges of each loop in order, counter-clockwise seen from where the field is positive.
    std::vector<std::vector<std::uint8_t>> loops;
    // The triangles of each loop, by its edges. No diagonal lies in a face of the cell, where the
    // neighbour might have the same one.
    std::vector<std::array<std::uint8_t, 3>> triangles;
    // Ambiguous faces that one loop crosses twice (bit f). If each loop were one vertex, two cells
    // with such a face in common would share an edge of four quads.
    std::uint8_t folded_faces = 0;
};

inline constexpr int kNoFace = 6;

// Returns the topology of a sign mask (bit c: corner c is behind the surface); on `joined_face` the
// corners behind are joined instead of kept apart. There are 256 masks, and 6 faces or kNoFace.
const CellTopology& cell_topology(int mask, int joined_face = kNoFace);

// The corners at the ends of a cell's edge.
struct CellEdge {
    std::uint8_t from;  // corner with the smaller coordinate
    std::uint8_t to;
};
CellEdge cell_edge(int edge);

}  // namespace divemesh::mesh
