#include "worker/mesh/marching_cubes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

#include "schemas/error.hpp"
#include "worker/mesh/cell_topology.hpp"
#include "worker/mesh/crossed_cells.hpp"
#include "worker/mesh/field_reader.hpp"
#include "worker/mesh/fill_colors.hpp"
#include "worker/mesh/run_phase.hpp"

namespace divemesh::mesh {
namespace {

constexpr float kMinFraction = 0.001F;  // of an edge, so that no two vertices coincide at a sample

// A crossed lattice edge that a cell uses: its start, its axis and the position of the zero.
struct EdgeVertex {
    Eigen::Vector3i cell;
    int axis;
    float fraction;
};

struct BlockEdges {
    // Index in `vertices`, of [sample][axis]; empty: no edge is crossed.
    std::vector<std::uint16_t> index;
    std::vector<EdgeVertex> vertices;
    std::uint32_t first_vertex = 0;
    std::vector<std::array<std::uint32_t, 3>> triangles;
};

constexpr std::uint16_t kNotCrossed = 0xffff;

class MarchingCubes {
public:
    MarchingCubes(const fusion::SignedDistanceField& field, const MeshingSettings& settings)
        : field_(field), settings_(settings), reader_(field), blocks_(field.blocks().size()) {
        if (reader_.min_level() != reader_.max_level())
            throw Error(ErrorCode::InvalidArgument,
                        "marching cubes cannot mesh a field of several levels: use surface nets");
    }

    types::Mesh run() {
        phase(0.0, 0.3, [this](std::size_t block) { find_vertices(block); });
        std::uint32_t num = 0;
        for (BlockEdges& edges : blocks_) {
            edges.first_vertex = num;
            num += static_cast<std::uint32_t>(edges.vertices.size());
        }
        phase(0.3, 0.6, [this](std::size_t block) { find_triangles(block); });
        return make_mesh(num);
    }

private:
    void phase(double begin, double end, const std::function<void(std::size_t)>& work) const {
        run_phase(field_, settings_, begin, end, blocks_.size(), work);
    }

    void find_vertices(std::size_t block);
    void find_triangles(std::size_t block);
    std::uint32_t vertex_of(const Eigen::Vector3i& cell, int edge) const;
    types::Mesh make_mesh(std::uint32_t num_vertices) const;

    const fusion::SignedDistanceField& field_;
    const MeshingSettings& settings_;
    FieldReader reader_;
    std::vector<BlockEdges> blocks_;
};

void MarchingCubes::find_vertices(std::size_t block) {
    BlockNeighbourhood samples;
    reader_.read(block, samples);
    BlockEdges& edges = blocks_[block];
    const Eigen::Vector3i first = fusion::first_sample(field_.blocks()[block]);
    const auto at = [&](const Eigen::Vector3i& s) {
        return samples.distances_m[BlockNeighbourhood::index(s.x(), s.y(), s.z())];
    };
    for (int i = 0; i < fusion::kBlockSamples; ++i) {
        const Eigen::Vector3i sample(i & 7, (i >> 3) & 7, i >> 6);
        const float from = at(sample);
        if (std::isnan(from)) continue;
        for (int axis = 0; axis < 3; ++axis) {
            const float to = at(sample + Eigen::Vector3i::Unit(axis));
            if (std::isnan(to) || (from < 0.0F) == (to < 0.0F)) continue;
            if (edges.index.empty())
                edges.index.assign(std::size_t{3} * fusion::kBlockSamples, kNotCrossed);
            edges.index[3 * i + axis] = static_cast<std::uint16_t>(edges.vertices.size());
            const float fraction =
                std::clamp(from / (from - to), kMinFraction, 1.0F - kMinFraction);
            edges.vertices.push_back({first + sample, axis, fraction});
        }
    }
}

void MarchingCubes::find_triangles(std::size_t block) {
    BlockNeighbourhood samples;
    reader_.read(block, samples);
    const Eigen::Vector3i first = fusion::first_sample(field_.blocks()[block]);
    for (const CrossedCell& cell : find_crossed_cells(samples)) {
        for (const auto& triangle : cell_topology(sign_mask(cell.corners_m)).triangles) {
            std::array<std::uint32_t, 3> vertices;
            for (int k = 0; k < 3; ++k) vertices[k] = vertex_of(first + cell.place, triangle[k]);
            blocks_[block].triangles.push_back(vertices);
        }
    }
}

std::uint32_t MarchingCubes::vertex_of(const Eigen::Vector3i& cell, int edge) const {
    const int from = cell_edge(edge).from;
    const Eigen::Vector3i sample =
        cell + Eigen::Vector3i(from & 1, (from >> 1) & 1, (from >> 2) & 1);
    const BlockEdges& edges = blocks_[reader_.find(fusion::block_of(sample, reader_.min_level()))];
    return edges.first_vertex + edges.index[3 * fusion::index_in_block(sample) + edge / 4];
}

types::Mesh MarchingCubes::make_mesh(std::uint32_t num_vertices) const {
    types::Mesh mesh;
    mesh.vertices.resize(num_vertices);
    mesh.normals.resize(num_vertices);
    mesh.colors.resize(num_vertices);
    mesh.sigma_m.resize(num_vertices);
    mesh.num_observations.resize(num_vertices);
    const int level = reader_.min_level();
    const auto voxel = static_cast<float>(reader_.step_m(level));
    mesh.voxel_m.assign(num_vertices, voxel);
    std::vector<std::uint8_t> has_color(num_vertices);
    phase(0.6, 1.0, [&](std::size_t block) {
        for (std::size_t i = 0; i < blocks_[block].vertices.size(); ++i) {
            const EdgeVertex& edge = blocks_[block].vertices[i];
            const std::size_t vertex = blocks_[block].first_vertex + i;
            const Eigen::Vector3f place = edge.fraction * Eigen::Vector3f::Unit(edge.axis);
            const fusion::SampleAttributes attributes = reader_.attributes(level, edge.cell, place);
            mesh.vertices[vertex] = voxel * (edge.cell.cast<float>() + place);
            mesh.normals[vertex] = reader_.edge_normal(level, edge.cell, edge.axis, edge.fraction);
            mesh.colors[vertex] = attributes.color;
            has_color[vertex] = attributes.has_color ? 1 : 0;
            mesh.sigma_m[vertex] = attributes.sigma_m;
            mesh.num_observations[vertex] = attributes.num_observations;
        }
    });
    for (const BlockEdges& block : blocks_)
        mesh.triangles.insert(mesh.triangles.end(), block.triangles.begin(), block.triangles.end());
    fill_colors(mesh, std::move(has_color));
    return mesh;
}

}  // namespace

types::Mesh marching_cubes(const fusion::SignedDistanceField& field,
                           const MeshingSettings& settings) {
    return MarchingCubes(field, settings).run();
}

}  // namespace divemesh::mesh
