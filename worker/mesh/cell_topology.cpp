#include "worker/mesh/cell_topology.hpp"

#include <algorithm>

namespace divemesh::mesh {
namespace {

constexpr int kNumFaces = 6;

int edge_between(int corner_a, int corner_b) {
    const int bit = corner_a ^ corner_b;
    const int axis = bit == 1 ? 0 : bit == 2 ? 1 : 2;
    const int from = corner_a & corner_b;
    return 4 * axis + ((from >> ((axis + 1) % 3)) & 1) + 2 * ((from >> ((axis + 2) % 3)) & 1);
}

// Returns the corners of a face, counter-clockwise seen from outside the cell.
std::array<int, 4> face_corners(int face) {
    const int axis = face / 2;
    const int u = 1 << ((axis + 1) % 3), v = 1 << ((axis + 2) % 3);
    const int base = (face & 1) << axis;
    if ((face & 1) != 0) return {base, base | u, base | u | v, base | v};
    return {base, base | v, base | u | v, base | u};
}

bool edge_on_face(int edge, int face) {
    const CellEdge ends = cell_edge(edge);
    const int axis = face / 2, side = face & 1;
    return ((ends.from >> axis) & 1) == side && ((ends.to >> axis) & 1) == side;
}

bool share_a_face(int edge_a, int edge_b) {
    for (int face = 0; face < kNumFaces; ++face)
        if (edge_on_face(edge_a, face) && edge_on_face(edge_b, face)) return true;
    return false;
}

bool is_ambiguous(int mask, int face) {
    const auto corners = face_corners(face);
    const auto behind = [&](int i) { return (mask >> corners[i]) & 1; };
    return behind(0) == behind(2) && behind(1) == behind(3) && behind(0) != behind(1);
}

// Returns for each crossed edge the next one in its loop. Around a face, seen from outside, a
// segment leads from the edge where the corners behind begin to the one where they end; on a joined
// face it leads to the previous such end.
std::array<int, 12> follow_segments(int mask, int joined_face) {
    std::array<int, 12> next;
    next.fill(-1);
    for (int face = 0; face < kNumFaces; ++face) {
        const auto corners = face_corners(face);
        const auto behind = [&](int i) { return ((mask >> corners[i & 3]) & 1) != 0; };
        const auto edge = [&](int i) { return edge_between(corners[i & 3], corners[(i + 1) & 3]); };
        for (int i = 0; i < 4; ++i) {
            if (behind(i) || !behind(i + 1)) continue;  // edge i: the corners behind begin
            int end = i + 1;
            while (behind(end + 1)) ++end;
            if (face == joined_face && is_ambiguous(mask, face)) end = i - 1 + 4;
            next[edge(i)] = edge(end);
        }
    }
    return next;
}

// Triangulates the polygon `loop` by ear clipping so that no diagonal lies in a face; tries every
// order.
bool triangulate(const std::vector<std::uint8_t>& loop,
                 std::vector<std::array<std::uint8_t, 3>>& triangles) {
    const std::size_t num = loop.size();
    if (num == 3) {
        triangles.push_back({loop[0], loop[1], loop[2]});
        return true;
    }
    for (std::size_t i = 0; i < num; ++i) {
        const std::uint8_t before = loop[(i + num - 1) % num], after = loop[(i + 1) % num];
        if (share_a_face(before, after)) continue;
        std::vector<std::uint8_t> rest = loop;
        rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(i));
        const std::size_t num_triangles = triangles.size();
        triangles.push_back({before, loop[i], after});
        if (triangulate(rest, triangles)) return true;
        triangles.resize(num_triangles);
    }
    return false;
}

CellTopology make_topology(int mask, int joined_face) {
    CellTopology topology;
    topology.loop_of_edge.fill(-1);
    const auto next = follow_segments(mask, joined_face);
    for (int start = 0; start < 12; ++start) {
        if (next[start] < 0 || topology.loop_of_edge[start] >= 0) continue;
        std::vector<std::uint8_t> loop;
        for (int edge = start; topology.loop_of_edge[edge] < 0; edge = next[edge]) {
            topology.loop_of_edge[edge] = static_cast<std::int16_t>(topology.loops.size());
            loop.push_back(static_cast<std::uint8_t>(edge));
        }
        triangulate(loop, topology.triangles);
        topology.loops.push_back(std::move(loop));
    }
    for (int face = 0; face < kNumFaces; ++face) {
        if (!is_ambiguous(mask, face) || face == joined_face) continue;
        const auto corners = face_corners(face);
        const int a = topology.loop_of_edge[edge_between(corners[0], corners[1])];
        const int b = topology.loop_of_edge[edge_between(corners[2], corners[3])];
        if (a == b) topology.folded_faces |= static_cast<std::uint8_t>(1 << face);
    }
    return topology;
}

}  // namespace

const CellTopology& cell_topology(int mask, int joined_face) {
    static const std::vector<CellTopology> kTable = [] {
        std::vector<CellTopology> made;
        for (int m = 0; m < 256; ++m)
            for (int face = 0; face <= kNoFace; ++face) made.push_back(make_topology(m, face));
        return made;
    }();
    return kTable[static_cast<std::size_t>(mask) * (kNoFace + 1) + joined_face];
}

CellEdge cell_edge(int edge) {
    const int axis = edge / 4;
    const int from = ((edge & 1) << ((axis + 1) % 3)) | (((edge >> 1) & 1) << ((axis + 2) % 3));
    return {static_cast<std::uint8_t>(from), static_cast<std::uint8_t>(from | (1 << axis))};
}

}  // namespace divemesh::mesh
