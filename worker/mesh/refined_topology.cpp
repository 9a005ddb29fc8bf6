#include "worker/mesh/refined_topology.hpp"

#include <utility>

namespace divemesh::mesh {
namespace {

constexpr int kNumNodes = 27;
constexpr int kNumEdges = 81;
constexpr int kNumFaces = 6;

int node_index(const Eigen::Vector3i& node) { return node.x() + 3 * node.y() + 9 * node.z(); }

// A part of a face: its nodes, counter-clockwise seen from outside the cell.
struct Part {
    int number = 0;
    std::vector<Eigen::Vector3i> nodes;

    int num_nodes() const { return static_cast<int>(nodes.size()); }
    const Eigen::Vector3i& node(int i) const { return nodes[i % num_nodes()]; }
};

class Tracer {
public:
    Tracer(const std::array<float, 8>& corners_m,
           std::uint32_t split_nodes,
           std::uint32_t joined_parts)
        : split_nodes_(split_nodes), joined_parts_(joined_parts) {
        next_.fill(-1);
        topology_.loop_of_edge.fill(-1);
        set_distances(corners_m);
    }

    RefinedTopology run() {
        for (int face = 0; face < kNumFaces; ++face) add_parts(face);
        for (const Part& part : parts_) follow_segments(part);
        for (int start = 0; start < kNumEdges; ++start)
            if (next_[start] >= 0 && topology_.loop_of_edge[start] < 0) add_loop(start);
        for (const Part& part : parts_)
            if (is_folded(part)) topology_.folded_parts |= 1U << part.number;
        return std::move(topology_);
    }

private:
    void set_distances(const std::array<float, 8>& corners_m);
    void add_parts(int face);
    Part whole(int face) const;
    void follow_segments(const Part& part);
    void add_loop(int start);
    bool is_folded(const Part& part) const;

    bool behind(const Part& part, int i) const {
        return distances_m_[node_index(part.node(i))] < 0.0F;
    }
    bool begins(const Part& part, int i) const { return !behind(part, i) && behind(part, i + 1); }
    bool ends(const Part& part, int i) const { return behind(part, i) && !behind(part, i + 1); }
    bool is_joined(const Part& part) const { return ((joined_parts_ >> part.number) & 1U) != 0; }
    static int edge(const Part& part, int i);

    std::uint32_t split_nodes_;
    std::uint32_t joined_parts_;
    std::array<float, kNumNodes> distances_m_;
    std::vector<Part> parts_;
    std::array<std::int16_t, kNumEdges> next_;      // edge of a loop, of each crossed edge
    std::array<std::int16_t, kNumEdges> length_{};  // in half edges
    RefinedTopology topology_;
};

void Tracer::set_distances(const std::array<float, 8>& corners_m) {
    const auto at = [&](int x, int y, int z) -> float& { return distances_m_[x + 3 * y + 9 * z]; };
    for (int c = 0; c < 8; ++c) at(2 * (c & 1), 2 * ((c >> 1) & 1), 2 * (c >> 2)) = corners_m[c];
    for (int z = 0; z < 3; z += 2)
        for (int y = 0; y < 3; y += 2) at(1, y, z) = 0.5F * (at(0, y, z) + at(2, y, z));
    for (int z = 0; z < 3; z += 2)
        for (int x = 0; x < 3; ++x) at(x, 1, z) = 0.5F * (at(x, 0, z) + at(x, 2, z));
    for (int y = 0; y < 3; ++y)
        for (int x = 0; x < 3; ++x) at(x, y, 1) = 0.5F * (at(x, y, 0) + at(x, y, 2));
}

void Tracer::add_parts(int face) {
    if (!is_split(split_nodes_, face)) {
        parts_.push_back(whole(face));
        return;
    }
    for (int quarter = 0; quarter < 4; ++quarter) {
        const int axis = face / 2;
        Eigen::Vector3i first = 2 * (face & 1) * Eigen::Vector3i::Unit(axis);
        Eigen::Vector3i u = Eigen::Vector3i::Unit((axis + 1) % 3);
        Eigen::Vector3i v = Eigen::Vector3i::Unit((axis + 2) % 3);
        first += (quarter & 1) * u + (quarter >> 1) * v;
        if ((face & 1) == 0) std::swap(u, v);
        parts_.push_back({4 * face + quarter, {first, first + u, first + u + v, first + v}});
    }
}

Part Tracer::whole(int face) const {
    const int axis = face / 2;
    const Eigen::Vector3i first = 2 * (face & 1) * Eigen::Vector3i::Unit(axis);
    Eigen::Vector3i u = Eigen::Vector3i::Unit((axis + 1) % 3);
    Eigen::Vector3i v = Eigen::Vector3i::Unit((axis + 2) % 3);
    if ((face & 1) == 0) std::swap(u, v);
    const std::array<Eigen::Vector3i, 8> around{first,
                                                first + u,
                                                first + 2 * u,
                                                first + 2 * u + v,
                                                first + 2 * u + 2 * v,
                                                first + u + 2 * v,
                                                first + 2 * v,
                                                first + v};
    Part part{.number = 4 * face, .nodes = {}};
    for (int i = 0; i < 8; ++i)
        if (i % 2 == 0 || ((split_nodes_ >> node_index(around[i])) & 1U) != 0)
            part.nodes.push_back(around[i]);
    return part;
}

int Tracer::edge(const Part& part, int i) {
    const Eigen::Vector3i along = part.node(i + 1) - part.node(i);
    const int axis = along.x() != 0 ? 0 : along.y() != 0 ? 1 : 2;
    return refined_edge(along.sum() > 0 ? part.node(i) : part.node(i + 1), axis);
}

// As in CellTopology: a segment leads from the edge where the nodes behind begin to the one where
// they end; in a joined part it leads to the previous such end.
void Tracer::follow_segments(const Part& part) {
    for (int i = 0; i < part.num_nodes(); ++i) {
        if (!begins(part, i)) continue;
        int end = i;
        const int step = is_joined(part) ? part.num_nodes() - 1 : 1;
        do end = (end + step) % part.num_nodes();
        while (!ends(part, end));
        next_[edge(part, i)] = static_cast<std::int16_t>(edge(part, end));
        for (const int k : {i, end})
            length_[edge(part, k)] =
                static_cast<std::int16_t>((part.node(k + 1) - part.node(k)).cwiseAbs().sum());
    }
}

void Tracer::add_loop(int start) {
    static constexpr std::array<int, 3> kStride = {1, 3, 9};
    RefinedTopology::Loop loop;
    for (int edge = start; topology_.loop_of_edge[edge] < 0; edge = next_[edge]) {
        topology_.loop_of_edge[edge] = static_cast<std::int16_t>(topology_.loops.size());
        const int node = edge / 3, axis = edge % 3;
        const auto length = static_cast<float>(length_[edge]);
        const float from = distances_m_[node];
        const float to = distances_m_[node + length_[edge] * kStride[axis]];
        Eigen::Vector3f zero = Eigen::Vector3i(node % 3, node / 3 % 3, node / 9).cast<float>();
        zero[axis] += length * from / (from - to);
        loop.crossing += 0.5F * zero;
        ++loop.num_edges;
    }
    loop.crossing /= static_cast<float>(loop.num_edges);
    topology_.loops.push_back(loop);
}

bool Tracer::is_folded(const Part& part) const {
    if (is_joined(part)) return false;
    const auto loop = [&](int i) { return topology_.loop_of_edge[edge(part, i)]; };
    for (int i = 0; i < part.num_nodes(); ++i)
        for (int k = 0; k < i; ++k)
            if (begins(part, i) && begins(part, k) && loop(i) == loop(k)) return true;
    return false;
}

}  // namespace

RefinedTopology refined_topology(const std::array<float, 8>& corners_m,
                                 std::uint32_t split_nodes,
                                 std::uint32_t joined_parts) {
    return Tracer(corners_m, split_nodes, joined_parts).run();
}

std::uint32_t nodes_towards(const Eigen::Vector3i& offset) {
    std::uint32_t nodes = 0;
    for (int z = 0; z < 3; ++z)
        for (int y = 0; y < 3; ++y)
            for (int x = 0; x < 3; ++x) {
                const Eigen::Vector3i node(x, y, z);
                const Eigen::Array3i side = node.array() - 1;  // -1 to 1
                const auto num_middle = (side == 0).count();
                const bool is_shared = (offset.array() == 0 || offset.array() == side).all();
                if (is_shared && num_middle > 0) nodes |= 1U << node_index(node);
            }
    return nodes;
}

bool is_split(std::uint32_t split_nodes, int face) {
    Eigen::Vector3i middle(1, 1, 1);
    middle[face / 2] = 2 * (face & 1);
    return ((split_nodes >> node_index(middle)) & 1U) != 0;
}

Eigen::Vector3i cell_behind(const Eigen::Vector3i& cell, int part) {
    const int face = part / 4, quarter = part % 4, axis = face / 2;
    Eigen::Vector3i behind = 2 * cell;
    behind[axis] += (face & 1) != 0 ? 2 : -1;
    behind[(axis + 1) % 3] += quarter & 1;
    behind[(axis + 2) % 3] += quarter >> 1;
    return behind;
}

int part_of_coarser(const Eigen::Vector3i& cell, int face_of_coarser) {
    const int axis = face_of_coarser / 2;
    return 4 * face_of_coarser + (cell[(axis + 1) % 3] & 1) + 2 * (cell[(axis + 2) % 3] & 1);
}

}  // namespace divemesh::mesh
