#include "worker/mesh/block_net.hpp"

#include <algorithm>

#include "worker/mesh/refined_topology.hpp"

namespace divemesh::mesh {

std::uint32_t vertex_at(const BlockNet& net, int cell, int edge) {
    if (net.cells.empty()) return kNoIndex;
    const ActiveCell& active = net.cells[cell];
    if (active.first_vertex == kNoVertex) return kNoIndex;
    if (active.joined_face == kRefined)
        return refined_vertex_at(
            net, cell, refined_edge(2 * corner_offset(cell_edge(edge).from), edge / 4));
    const int loop = cell_topology(active.mask, active.joined_face).loop_of_edge[edge];
    return net.first_vertex + active.first_vertex + static_cast<std::uint32_t>(loop);
}

std::uint32_t refined_vertex_at(const BlockNet& net, int cell, int edge) {
    const auto found = std::lower_bound(
        net.refined.begin(), net.refined.end(), cell, [](const RefinedCell& refined, int number) {
            return refined.cell < number;
        });
    if (found == net.refined.end() || found->cell != cell) return kNoIndex;
    const int loop = found->loop_of_edge[edge];
    if (loop < 0) return kNoIndex;
    return net.first_vertex + net.cells[cell].first_vertex + static_cast<std::uint32_t>(loop);
}

void add_cell(BlockNet& net,
              int level,
              const Eigen::Vector3i& first_sample,
              const CrossedCell& cell,
              int joined_face) {
    const std::array<float, 8>& at = cell.corners_m;
    ActiveCell& active = net.cells[fusion::index_in_block(cell.place)];
    active.mask = static_cast<std::uint8_t>(sign_mask(at));
    active.joined_face = static_cast<std::uint8_t>(joined_face);
    active.first_vertex = static_cast<std::uint16_t>(net.vertices.size());
    const CellTopology& topology = cell_topology(active.mask, active.joined_face);
    for (const auto& loop : topology.loops) {
        NetVertex vertex{.cell = first_sample + cell.place,
                         .crossing = Eigen::Vector3f::Zero(),
                         .corners_m = at,
                         .level = static_cast<std::int16_t>(level),
                         .single = topology.loops.size() == 1};
        for (const int edge : loop) {
            const CellEdge ends = cell_edge(edge);
            const float t = at[ends.from] / (at[ends.from] - at[ends.to]);
            for (int axis = 0; axis < 3; ++axis) {
                const auto from = static_cast<float>((ends.from >> axis) & 1);
                const auto to = static_cast<float>((ends.to >> axis) & 1);
                vertex.crossing[axis] += from + t * (to - from);
            }
        }
        vertex.crossing /= static_cast<float>(loop.size());
        net.vertices.push_back(vertex);
    }
}

}  // namespace divemesh::mesh
