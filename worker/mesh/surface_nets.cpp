#include "worker/mesh/surface_nets.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <numeric>
#include <vector>

#include "worker/base/uninitialised_vector.hpp"
#include "worker/mesh/block_net.hpp"
#include "worker/mesh/block_surroundings.hpp"
#include "worker/mesh/field_reader.hpp"
#include "worker/mesh/fill_colors.hpp"
#include "worker/mesh/level_transitions.hpp"
#include "worker/mesh/run_phase.hpp"

namespace divemesh::mesh {
namespace {

using Quad = std::array<std::uint32_t, 4>;

class SurfaceNets {
public:
    SurfaceNets(const fusion::SignedDistanceField& field, const MeshingSettings& settings)
        : field_(field), settings_(settings), reader_(field), nets_(field.blocks().size()) {}

    types::Mesh run() {
        phase(0.0, 0.4, nets_.size(), [this](std::size_t block) { find_vertices(block); });
        number_vertices();
        polygons_.resize(nets_.size());
        phase(0.4, 0.5, nets_.size(), [this](std::size_t block) { find_polygons(block); });
        link_neighbours();
        read_attributes();
        relax();
        return make_mesh();
    }

private:
    void phase(double begin,
               double end,
               std::size_t num,
               const std::function<void(std::size_t)>& work) const {
        run_phase(field_, settings_, begin, end, num, work);
    }

    void find_vertices(std::size_t block);
    int face_to_join(int level, int mask, const Eigen::Vector3i& cell) const;
    void number_vertices();
    void find_polygons(std::size_t block);
    void find_polygons_between_levels(std::size_t block);
    void add_quads(std::size_t block, const ActiveCell& cell, const Eigen::Vector3i& sample);
    void add_quad(std::size_t block, const Eigen::Vector3i& sample, int axis, bool behind);
    std::uint32_t vertex_of(const Eigen::Vector3i& cell, int edge, std::size_t expected) const;
    void link_neighbours();
    void collect_links();
    void sort_links(std::size_t vertex);
    void read_attributes();
    void relax();
    Eigen::Vector3f place_from(const NetVertex& here, std::uint32_t vertex) const;
    Eigen::Vector3f relaxed(std::size_t vertex) const;
    types::Mesh make_mesh();
    void set_vertex(std::size_t vertex, types::Mesh& mesh) const;
    void set_triangles(std::size_t block, std::size_t first, types::Mesh& mesh) const;

    const fusion::SignedDistanceField& field_;
    const MeshingSettings& settings_;
    FieldReader reader_;
    std::vector<BlockNet> nets_;
    std::vector<BlockPolygons> polygons_;
    base::UninitialisedVector<NetVertex> vertices_;
    std::vector<Eigen::Vector3f> places_;  // of the vertices in their cells, 0 to 1
    std::vector<fusion::SampleAttributes> attributes_;
    base::UninitialisedVector<std::uint32_t>
        links_;  // to the neighbours of all vertices, one vertex after another
    std::vector<std::uint32_t> first_link_;  // of each vertex, plus one past the end
    std::vector<std::uint8_t> num_neighbours_;
    std::vector<std::uint8_t> on_border_;
};

void SurfaceNets::find_vertices(std::size_t block) {
    BlockNet& net = nets_[block];
    if (reader_.min_level() != reader_.max_level()) {
        const BlockSurroundings here(reader_, block);
        if (!here.one_level()) return find_vertices_between_levels(reader_, here, net);
    }
    BlockNeighbourhood samples;
    reader_.read(block, samples);
    const auto crossed = find_crossed_cells(samples);
    if (crossed.empty()) return;
    const int level = field_.blocks()[block].level;
    const Eigen::Vector3i first = fusion::first_sample(field_.blocks()[block]);
    net.cells.resize(fusion::kBlockSamples);
    for (const CrossedCell& cell : crossed)
        add_cell(net,
                 level,
                 first,
                 cell,
                 face_to_join(level, sign_mask(cell.corners_m), first + cell.place));
}

// Returns a face that is folded in this cell and in the one behind it; it is joined in both.
int SurfaceNets::face_to_join(int level, int mask, const Eigen::Vector3i& cell) const {
    const int folded = cell_topology(mask).folded_faces;
    for (int face = 0; face < kNoFace && folded != 0; ++face) {
        if (((folded >> face) & 1) == 0) continue;
        Eigen::Vector3i other = cell;
        other[face / 2] += (face & 1) != 0 ? 1 : -1;
        std::array<float, 8> corners;
        if (!reader_.read_cell(level, other, corners)) continue;
        if (((cell_topology(sign_mask(corners)).folded_faces >> (face ^ 1)) & 1) != 0) return face;
    }
    return kNoFace;
}

void SurfaceNets::number_vertices() {
    std::size_t num = 0;
    for (BlockNet& net : nets_) {
        net.first_vertex = static_cast<std::uint32_t>(num);
        num += net.vertices.size();
    }
    vertices_.resize(num);
    places_.resize(num);
    base::for_each_index(settings_.num_threads, nets_.size(), [this](std::size_t block) {
        BlockNet& net = nets_[block];
        for (std::size_t i = 0; i < net.vertices.size(); ++i) {
            vertices_[net.first_vertex + i] = net.vertices[i];
            places_[net.first_vertex + i] = net.vertices[i].crossing;
        }
        net.vertices = {};
    });
}

// Every lattice edge that begins in the block and changes sign is the centre of a quad between its
// four cells, if each of them has a vertex. One of the four is the cell at the start of the edge.
void SurfaceNets::find_polygons(std::size_t block) {
    const BlockNet& net = nets_[block];
    if (net.cells.empty()) return;
    if (!net.one_level) return find_polygons_between_levels(block);
    const Eigen::Vector3i first = fusion::first_sample(field_.blocks()[block]);
    for (int i = 0; i < fusion::kBlockSamples; ++i)
        if (net.cells[i].first_vertex != kNoVertex)
            add_quads(block, net.cells[i], first + Eigen::Vector3i(i & 7, (i >> 3) & 7, i >> 6));
}

void SurfaceNets::find_polygons_between_levels(std::size_t block) {
    const BlockNet& net = nets_[block];
    const BlockSurroundings here(reader_, block);
    for (int i = 0; i < fusion::kBlockSamples; ++i) {
        if (net.cells[i].first_vertex == kNoVertex) continue;
        const Eigen::Vector3i place(i & 7, (i >> 3) & 7, i >> 6);
        const Eigen::Vector3i cell = here.first_sample() + place;
        if (place.minCoeff() > 0 && place.maxCoeff() < fusion::kBlockEdge - 1)
            add_quads(block, net.cells[i], cell);
        else
            add_polygons_between_levels(reader_, here, nets_, net.cells[i], cell, polygons_[block]);
    }
}

void SurfaceNets::add_quads(std::size_t block,
                            const ActiveCell& cell,
                            const Eigen::Vector3i& sample) {
    const bool behind = (cell.mask & 1) != 0;
    for (int axis = 0; axis < 3; ++axis)
        if (behind != (((cell.mask >> (1 << axis)) & 1) != 0))
            add_quad(block, sample, axis, behind);
}

void SurfaceNets::add_quad(std::size_t block,
                           const Eigen::Vector3i& sample,
                           int axis,
                           bool behind) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    static constexpr int kAround[4][2] = {{-1, -1}, {0, -1}, {0, 0}, {-1, 0}};
    Quad quad;
    for (int i = 0; i < 4; ++i) {
        Eigen::Vector3i cell = sample;
        cell[u] += kAround[i][0];
        cell[v] += kAround[i][1];
        const int edge = 4 * axis - kAround[i][0] - 2 * kAround[i][1];
        quad[i] = vertex_of(cell, edge, block);
        if (quad[i] == kNoIndex) return;
    }
    if (!behind) std::swap(quad[1], quad[3]);
    polygons_[block].quads.push_back(quad);
}

// The `expected` block is tried first, as it contains most cells.
std::uint32_t SurfaceNets::vertex_of(const Eigen::Vector3i& cell,
                                     int edge,
                                     std::size_t expected) const {
    const fusion::BlockCoordinate& here = field_.blocks()[expected];
    const fusion::BlockCoordinate place = fusion::block_of(cell, here.level);
    const std::size_t block = place == here ? expected : reader_.find(place);
    if (block == FieldReader::kNone) return kNoIndex;
    return vertex_at(nets_[block], fusion::index_in_block(cell), edge);
}

// Links vertices along each side of each polygon. A side of only one polygon is border: its ends do
// not move, or the net would shrink.
void SurfaceNets::link_neighbours() {
    collect_links();
    settings_.progress.at(0.55);
    num_neighbours_.assign(vertices_.size(), 0);
    on_border_.assign(vertices_.size(), 0);
    phase(0.55, 0.6, vertices_.size(), [this](std::size_t vertex) { sort_links(vertex); });
}

// Collects both directions of each side of each polygon, so that a side between two of them occurs
// twice. The order depends on the threads; sort_links() makes it deterministic.
void SurfaceNets::collect_links() {
    first_link_.assign(vertices_.size() + 2, 0);
    const auto advanced = [this](std::uint32_t vertex, std::size_t ahead) {
        return std::atomic_ref(first_link_[vertex + ahead]).fetch_add(2, std::memory_order_relaxed);
    };
    const auto count = [&](const auto& polygon) {
        for (const std::uint32_t vertex : polygon) advanced(vertex, 2);
    };
    base::for_each_index(settings_.num_threads, polygons_.size(), [&](std::size_t block) {
        for (const auto& quad : polygons_[block].quads) count(quad);
        for (const auto& triangle : polygons_[block].triangles) count(triangle);
    });
    std::inclusive_scan(first_link_.begin(), first_link_.end(), first_link_.begin());
    links_.resize(first_link_.back());
    // first_link_[v + 1] advances from the start to the end of v's links.
    const auto link = [&](const auto& polygon) {
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const std::uint32_t place = advanced(polygon[i], 1);
            links_[place] = polygon[(i + 1) % polygon.size()];
            links_[place + 1] = polygon[(i + polygon.size() - 1) % polygon.size()];
        }
    };
    base::for_each_index(settings_.num_threads, polygons_.size(), [&](std::size_t block) {
        for (const auto& quad : polygons_[block].quads) link(quad);
        for (const auto& triangle : polygons_[block].triangles) link(triangle);
    });
}

// Sorts the links of a vertex and keeps each neighbour once.
void SurfaceNets::sort_links(std::size_t vertex) {
    const auto begin = links_.begin() + first_link_[vertex];
    const auto end = links_.begin() + first_link_[vertex + 1];
    std::sort(begin, end);
    auto kept = begin;
    for (auto link = begin; link != end;) {
        const auto next = std::upper_bound(link, end, *link);
        if (next - link == 1) on_border_[vertex] = 1;
        *kept++ = *link;
        link = next;
    }
    num_neighbours_[vertex] = static_cast<std::uint8_t>(kept - begin);
}

void SurfaceNets::read_attributes() {
    attributes_.resize(vertices_.size());
    phase(0.6, 0.75, vertices_.size(), [this](std::size_t i) {
        attributes_[i] = reader_.attributes(vertices_[i].level, vertices_[i].cell, places_[i]);
    });
}

void SurfaceNets::relax() {
    std::vector<Eigen::Vector3f> next(places_.size());
    for (int round = 0; round < settings_.num_relaxations; ++round) {
        const double done = round, all = settings_.num_relaxations;
        phase(0.75 + 0.2 * done / all,
              0.75 + 0.2 * (done + 1.0) / all,
              places_.size(),
              [&](std::size_t i) { next[i] = relaxed(i); });
        places_.swap(next);
    }
}

// Returns where a vertex is in the cell of another one.
Eigen::Vector3f SurfaceNets::place_from(const NetVertex& here, std::uint32_t vertex) const {
    const NetVertex& there = vertices_[vertex];
    if (there.level == here.level) return (there.cell - here.cell).cast<float>() + places_[vertex];
    const int finest = std::min(there.level, here.level);
    const Eigen::Vector3i between =
        point_at(there.level, there.cell, finest) - point_at(here.level, here.cell, finest);
    return std::ldexp(1.0F, finest - here.level) * between.cast<float>() +
           std::ldexp(1.0F, there.level - here.level) * places_[vertex];
}

Eigen::Vector3f SurfaceNets::relaxed(std::size_t vertex) const {
    const NetVertex& here = vertices_[vertex];
    Eigen::Vector3f place = places_[vertex];
    if (!here.single) return place;
    const std::uint32_t begin = first_link_[vertex], end = begin + num_neighbours_[vertex];
    if (on_border_[vertex] == 0 && begin != end) {
        Eigen::Vector3f mean = Eigen::Vector3f::Zero();
        for (std::uint32_t i = begin; i < end; ++i) mean += place_from(here, links_[i]);
        place += 0.5F * (mean / static_cast<float>(end - begin) - place);
    }
    place = place.cwiseMax(0.0F).cwiseMin(1.0F);
    const float slack = attributes_[vertex].sigma_m;
    for (int round = 0; round < 3; ++round) {  // alternate between the zero and the cell
        const auto [distance, gradient] = cell_at(here.corners_m, place);
        const float slope = gradient.squaredNorm();
        const float excess = distance - std::clamp(distance, -slack, slack);
        if (excess == 0.0F || slope == 0.0F) break;
        const Eigen::Vector3f back = gradient * (-excess / slope);
        place += back * std::min(1.0F, 0.5F / std::max(1e-9F, back.norm()));
        place = place.cwiseMax(0.0F).cwiseMin(1.0F);
    }
    return place;
}

types::Mesh SurfaceNets::make_mesh() {
    links_ = {};
    first_link_ = {};
    types::Mesh mesh;
    const std::size_t num_vertices = vertices_.size();
    mesh.vertices.resize(num_vertices);
    mesh.normals.resize(num_vertices);
    mesh.colors.resize(num_vertices);
    mesh.sigma_m.resize(num_vertices);
    mesh.num_observations.resize(num_vertices);
    mesh.voxel_m.resize(num_vertices);
    phase(0.95, 0.97, num_vertices, [&](std::size_t vertex) { set_vertex(vertex, mesh); });
    vertices_ = {};
    places_ = {};
    std::vector<std::size_t> first_triangle;
    std::size_t num_triangles = 0;
    for (const BlockPolygons& polygons : polygons_) {
        first_triangle.push_back(num_triangles);
        num_triangles += 2 * polygons.quads.size() + polygons.triangles.size();
    }
    mesh.triangles.resize(num_triangles);
    phase(0.97, 1.0, polygons_.size(), [&](std::size_t block) {
        set_triangles(block, first_triangle[block], mesh);
    });
    std::vector<std::uint8_t> has_color(num_vertices);
    for (std::size_t i = 0; i < num_vertices; ++i) has_color[i] = attributes_[i].has_color ? 1 : 0;
    fill_colors(mesh, std::move(has_color));
    return mesh;
}

void SurfaceNets::set_vertex(std::size_t vertex, types::Mesh& mesh) const {
    const NetVertex& net = vertices_[vertex];
    const Eigen::Vector3f& place = places_[vertex];
    const Eigen::Vector3f gradient = cell_at(net.corners_m, place).gradient_m;
    const fusion::SampleAttributes& attributes = attributes_[vertex];
    const auto voxel_m = static_cast<float>(reader_.step_m(net.level));
    mesh.vertices[vertex] = voxel_m * (net.cell.cast<float>() + place);
    mesh.normals[vertex] =
        gradient.norm() > 0.0F ? Eigen::Vector3f(gradient.normalized()) : Eigen::Vector3f::UnitZ();
    mesh.colors[vertex] = attributes.color;
    mesh.sigma_m[vertex] = attributes.sigma_m;
    mesh.num_observations[vertex] = attributes.num_observations;
    mesh.voxel_m[vertex] = voxel_m;
}

// Splits each quad along its shorter diagonal.
void SurfaceNets::set_triangles(std::size_t block, std::size_t first, types::Mesh& mesh) const {
    for (const Quad& q : polygons_[block].quads) {
        const auto diagonal = [&](int a, int b) {
            return (mesh.vertices[q[a]] - mesh.vertices[q[b]]).squaredNorm();
        };
        const int start = diagonal(0, 2) <= diagonal(1, 3) ? 0 : 1;
        mesh.triangles[first++] = {q[start], q[start + 1], q[start + 2]};
        mesh.triangles[first++] = {q[start], q[start + 2], q[(start + 3) & 3]};
    }
    for (const auto& triangle : polygons_[block].triangles) mesh.triangles[first++] = triangle;
}

}  // namespace

types::Mesh surface_nets(const fusion::SignedDistanceField& field,
                         const MeshingSettings& settings) {
    return SurfaceNets(field, settings).run();
}

}  // namespace divemesh::mesh
