#include "worker/mesh/level_transitions.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "worker/mesh/refined_topology.hpp"

namespace divemesh::mesh {
namespace {

constexpr std::size_t kNone = FieldReader::kNone;
constexpr int kNumParts = 24;

bool is_on_boundary(const Eigen::Vector3i& place) {
    return place.minCoeff() == 0 || place.maxCoeff() == fusion::kBlockEdge - 1;
}

// Returns whether a part of a face is folded as long as no part is joined.
bool is_folded(const std::array<float, 8>& corners_m, std::uint32_t split_nodes, int part) {
    if (std::any_of(corners_m.begin(), corners_m.end(), [](float d) { return std::isnan(d); }))
        return false;
    if (split_nodes != 0)
        return ((refined_topology(corners_m, split_nodes).folded_parts >> part) & 1U) != 0;
    return ((cell_topology(sign_mask(corners_m)).folded_faces >> (part / 4)) & 1) != 0;
}

class Transition {
public:
    Transition(const FieldReader& reader, const BlockSurroundings& here)
        : reader_(reader), here_(here) {}

    void add(const CrossedCell& crossed, BlockNet& net) const;

private:
    int face_to_join(int mask, const Eigen::Vector3i& cell) const;
    std::uint32_t parts_to_join(const Eigen::Vector3i& cell,
                                std::uint32_t split_nodes,
                                std::uint32_t folded_parts) const;
    bool is_folded_behind(const Eigen::Vector3i& cell, int part, bool is_quarter) const;
    void add_refined(const CrossedCell& crossed, std::uint32_t split_nodes, BlockNet& net) const;

    const FieldReader& reader_;
    const BlockSurroundings& here_;
};

void Transition::add(const CrossedCell& crossed, BlockNet& net) const {
    const Eigen::Vector3i cell = here_.first_sample() + crossed.place;
    const std::uint32_t split_nodes = is_on_boundary(crossed.place) ? here_.split_nodes(cell) : 0;
    if (split_nodes != 0)
        add_refined(crossed, split_nodes, net);
    else
        add_cell(net,
                 here_.level(),
                 here_.first_sample(),
                 crossed,
                 face_to_join(sign_mask(crossed.corners_m), cell));
}

// Returns a face that is folded in this cell and in the one behind it; it is joined in both.
int Transition::face_to_join(int mask, const Eigen::Vector3i& cell) const {
    const int folded = cell_topology(mask).folded_faces;
    for (int face = 0; face < kNoFace && folded != 0; ++face)
        if (((folded >> face) & 1) != 0 && is_folded_behind(cell, 4 * face, false)) return face;
    return kNoFace;
}

std::uint32_t Transition::parts_to_join(const Eigen::Vector3i& cell,
                                        std::uint32_t split_nodes,
                                        std::uint32_t folded_parts) const {
    std::uint32_t joined = 0;
    for (int part = 0; part < kNumParts; ++part)
        if (((folded_parts >> part) & 1U) != 0 &&
            is_folded_behind(cell, part, is_split(split_nodes, part / 4)))
            joined |= 1U << part;
    return joined;
}

// Returns whether the part of the cell's face is folded in the cell on its other side, which may be
// of any level.
bool Transition::is_folded_behind(const Eigen::Vector3i& cell, int part, bool is_quarter) const {
    const int face = part / 4;
    int level = here_.level();
    Eigen::Vector3i other = cell;
    other[face / 2] += (face & 1) != 0 ? 1 : -1;
    if (is_quarter) {
        other = cell_behind(cell, part);
        --level;
    }
    const std::size_t block = here_.find(level, other);
    if (block == kNone) return false;
    const BlockSurroundings there(reader_, block);
    int part_there = 4 * (face ^ 1);
    if (there.level() > level) part_there = part_of_coarser(other, face ^ 1);
    other = point_at(level, other, there.level());
    return is_folded(there.read_cell(other), there.split_nodes(other), part_there);
}

void Transition::add_refined(const CrossedCell& crossed,
                             std::uint32_t split_nodes,
                             BlockNet& net) const {
    const int index = fusion::index_in_block(crossed.place);
    const Eigen::Vector3i cell = here_.first_sample() + crossed.place;
    RefinedTopology topology = refined_topology(crossed.corners_m, split_nodes);
    if (const std::uint32_t joined = parts_to_join(cell, split_nodes, topology.folded_parts);
        joined != 0)
        topology = refined_topology(crossed.corners_m, split_nodes, joined);
    net.cells[index] = {.first_vertex = static_cast<std::uint16_t>(net.vertices.size()),
                        .mask = static_cast<std::uint8_t>(sign_mask(crossed.corners_m)),
                        .joined_face = kRefined};
    net.refined.push_back({static_cast<std::uint16_t>(index), topology.loop_of_edge});
    for (const RefinedTopology::Loop& loop : topology.loops)
        net.vertices.push_back({.cell = cell,
                                .crossing = loop.crossing,
                                .corners_m = crossed.corners_m,
                                .level = static_cast<std::int16_t>(here_.level()),
                                .single = topology.loops.size() == 1});
}

// The cells around an edge, in order.
constexpr int kAround[4][2] = {{-1, -1}, {0, -1}, {0, 0}, {-1, 0}};

class EdgePolygons {
public:
    EdgePolygons(const FieldReader& reader,
                 const BlockSurroundings& here,
                 const std::vector<BlockNet>& nets)
        : blocks_(reader.field().blocks()), here_(here), nets_(nets) {}

    // Adds the polygon of an edge of a cell, if the cell is the one that adds it.
    void add(const Eigen::Vector3i& cell, int edge, bool behind, BlockPolygons& out) const;

private:
    // Returns the vertices around the edge; empty if another cell adds it or if a cell has none.
    std::vector<std::uint32_t> vertices_around(const Eigen::Vector3i& sample, int edge) const;

    const std::vector<fusion::BlockCoordinate>& blocks_;
    const BlockSurroundings& here_;
    const std::vector<BlockNet>& nets_;
};

void EdgePolygons::add(const Eigen::Vector3i& cell,
                       int edge,
                       bool behind,
                       BlockPolygons& out) const {
    std::vector<std::uint32_t> around =
        vertices_around(cell + corner_offset(cell_edge(edge).from), edge);
    around.erase(std::unique(around.begin(), around.end()), around.end());
    if (around.size() > 1 && around.front() == around.back()) around.pop_back();
    if (!behind) std::reverse(around.begin(), around.end());
    if (around.size() == 4) out.quads.push_back({around[0], around[1], around[2], around[3]});
    if (around.size() == 3) out.triangles.push_back({around[0], around[1], around[2]});
}

// The cell for which the edge has the lowest number, among those of the edge's level, adds it.
std::vector<std::uint32_t> EdgePolygons::vertices_around(const Eigen::Vector3i& sample,
                                                         int edge) const {
    const int axis = edge / 4, u = (axis + 1) % 3, v = (axis + 2) % 3;
    std::vector<std::uint32_t> around;
    for (const auto& [along_u, along_v] : kAround) {
        Eigen::Vector3i cell = sample;
        cell[u] += along_u;
        cell[v] += along_v;
        const std::size_t block = here_.find(here_.level(), cell);
        if (block == kNone) return {};
        const int level = blocks_[block].level;
        const int edge_there = 4 * axis - along_u - 2 * along_v;
        if (level < here_.level() || (level == here_.level() && edge_there < edge)) return {};
        const Eigen::Vector3i owner = point_at(here_.level(), cell, level);
        const int index = fusion::index_in_block(owner);
        const std::uint32_t vertex =
            level == here_.level()
                ? vertex_at(nets_[block], index, edge_there)
                : refined_vertex_at(
                      nets_[block],
                      index,
                      refined_edge(sample - point_at(level, owner, here_.level()), axis));
        if (vertex == kNoIndex) return {};
        around.push_back(vertex);
    }
    return around;
}

}  // namespace

void find_vertices_between_levels(const FieldReader& reader,
                                  const BlockSurroundings& here,
                                  BlockNet& net) {
    net.one_level = false;
    BlockNeighbourhood samples;
    here.read(samples);
    const auto crossed = find_crossed_cells(samples);
    if (crossed.empty()) return;
    net.cells.resize(fusion::kBlockSamples);
    const Transition transition(reader, here);
    for (const CrossedCell& cell : crossed) transition.add(cell, net);
}

void add_polygons_between_levels(const FieldReader& reader,
                                 const BlockSurroundings& here,
                                 const std::vector<BlockNet>& nets,
                                 const ActiveCell& active,
                                 const Eigen::Vector3i& cell,
                                 BlockPolygons& polygons) {
    const EdgePolygons edges(reader, here, nets);
    for (int edge = 0; edge < 12; ++edge) {
        const CellEdge ends = cell_edge(edge);
        const bool behind = ((active.mask >> ends.from) & 1) != 0;
        if (behind != (((active.mask >> ends.to) & 1) != 0))
            edges.add(cell, edge, behind, polygons);
    }
}

}  // namespace divemesh::mesh
