#include "worker/mesh/field_reader.hpp"

#include <algorithm>
#include <cmath>

namespace divemesh::mesh {
namespace {

float corner_weight(int corner, const Eigen::Vector3f& place) {
    float weight = 1.0F;
    for (int axis = 0; axis < 3; ++axis)
        weight *= ((corner >> axis) & 1) != 0 ? place[axis] : 1.0F - place[axis];
    return weight;
}

float between(float from, float to, float share) { return from + share * (to - from); }

}  // namespace

FieldReader::FieldReader(const fusion::SignedDistanceField& field) : field_(field) {
    index_.reserve(field.blocks().size());
    for (std::size_t i = 0; i < field.blocks().size(); ++i) index_.emplace(field.blocks()[i], i);
    if (field.blocks().empty()) return;
    const auto [min, max] = std::minmax_element(
        field.blocks().begin(), field.blocks().end(), [](const auto& a, const auto& b) {
            return a.level < b.level;
        });
    min_level_ = min->level;
    max_level_ = max->level;
}

std::size_t FieldReader::find(const fusion::BlockCoordinate& block) const {
    const auto found = index_.find(block);
    return found == index_.end() ? kNone : found->second;
}

std::size_t FieldReader::find_any(int level, const Eigen::Vector3i& sample) const {
    for (int at = min_level_; at <= max_level_; ++at)
        if (const std::size_t block = find(fusion::block_of(point_at(level, sample, at), at));
            block != kNone)
            return block;
    return kNone;
}

void FieldReader::read(std::size_t block, BlockNeighbourhood& out) const {
    std::array<float, fusion::kBlockSamples> distances;
    field_.read_distances(block, distances.data());
    for (int z = 0; z < fusion::kBlockEdge; ++z)
        for (int y = 0; y < fusion::kBlockEdge; ++y)
            std::copy_n(distances.begin() + fusion::sample_index(0, y, z),
                        fusion::kBlockEdge,
                        out.distances_m.begin() + BlockNeighbourhood::index(0, y, z));
    const fusion::BlockCoordinate& here = field_.blocks()[block];
    for (int n = 1; n < 8; ++n) {
        const fusion::BlockCoordinate offset{n & 1, (n >> 1) & 1, (n >> 2) & 1};
        const std::size_t neighbour = find(here + offset);
        const int num_x = offset.x != 0 ? 1 : fusion::kBlockEdge;
        const int num_y = offset.y != 0 ? 1 : fusion::kBlockEdge;
        const int num_z = offset.z != 0 ? 1 : fusion::kBlockEdge;
        for (int z = 0; z < num_z; ++z)
            for (int y = 0; y < num_y; ++y)
                for (int x = 0; x < num_x; ++x)
                    out.distances_m[BlockNeighbourhood::index(x + fusion::kBlockEdge * offset.x,
                                                              y + fusion::kBlockEdge * offset.y,
                                                              z + fusion::kBlockEdge * offset.z)] =
                        neighbour == kNone
                            ? fusion::kUnknownDistance
                            : field_.distance_m(neighbour, fusion::sample_index(x, y, z));
    }
}

std::array<std::size_t, 8> FieldReader::blocks_around(int level,
                                                      const Eigen::Vector3i& cell) const {
    std::array<std::size_t, 8> blocks;
    blocks[0] = find(fusion::block_of(cell, level));
    for (int corner = 1; corner < 8; ++corner) {
        const Eigen::Vector3i sample = cell + corner_offset(corner);
        // The neighbouring corner one step back along one axis.
        const int before = corner & (corner - 1);
        const bool same =
            fusion::block_of(sample) == fusion::block_of(cell + corner_offset(before));
        blocks[corner] = same ? blocks[before] : find(fusion::block_of(sample, level));
    }
    return blocks;
}

bool FieldReader::read_cell(int level,
                            const Eigen::Vector3i& cell,
                            std::array<float, 8>& corners_m) const {
    const auto blocks = blocks_around(level, cell);
    for (int corner = 0; corner < 8; ++corner) {
        const Eigen::Vector3i sample = cell + corner_offset(corner);
        const std::size_t block = blocks[corner];
        if (block == kNone) return false;
        corners_m[corner] = field_.distance_m(block, fusion::index_in_block(sample));
        if (std::isnan(corners_m[corner])) return false;
    }
    return true;
}

template <typename Visit>
void FieldReader::visit_other_levels(int level,
                                     const Eigen::Vector3i& sample,
                                     const Visit& visit) const {
    const std::size_t block = find_any(level, sample);
    if (block == kNone) return;
    const int other = field_.blocks()[block].level;
    const Eigen::Vector3i first = point_at(level, sample, other);
    const Eigen::Vector3i rest = sample - point_at(other, first, level);
    for (int corner = 0; corner < 8; ++corner) {  // around the point, where it has none of its own
        Eigen::Vector3i point = first;
        float share = 1.0F;
        for (int axis = 0; axis < 3; ++axis) {
            const bool far = ((corner >> axis) & 1) != 0;
            const auto part =
                other > level ? std::ldexp(static_cast<float>(rest[axis]), level - other) : 0.0F;
            point[axis] += far ? 1 : 0;
            share *= far ? part : 1.0F - part;
        }
        if (share > 0.0F && fusion::block_of(point, other) == field_.blocks()[block])
            visit(block, fusion::index_in_block(point), share);
    }
}

fusion::SampleAttributes FieldReader::attributes(int level,
                                                 const Eigen::Vector3i& cell,
                                                 const Eigen::Vector3f& place) const {
    fusion::SampleAttributes mean;
    Eigen::Vector3f color = Eigen::Vector3f::Zero();
    float color_weight = 0.0F;
    float count = 0.0F;
    float weights = 0.0F;
    const auto add = [&](std::size_t block, int index, float weight) {
        const fusion::SampleAttributes here = field_.attributes(block, index);
        weights += weight;
        mean.sigma_m += weight * here.sigma_m;
        count += weight * static_cast<float>(here.num_observations);
        if (!here.has_color) return;
        color_weight += weight;
        color += weight * Eigen::Vector3f(here.color[0], here.color[1], here.color[2]);
    };
    const auto blocks = blocks_around(level, cell);
    for (int corner = 0; corner < 8; ++corner) {
        const Eigen::Vector3i sample = cell + corner_offset(corner);
        const float weight = corner_weight(corner, place) + 1e-3F;
        if (blocks[corner] != kNone)
            add(blocks[corner], fusion::index_in_block(sample), weight);
        else if (min_level_ != max_level_)
            visit_other_levels(level, sample, [&](std::size_t block, int index, float share) {
                add(block, index, share * weight);
            });
    }
    if (weights <= 0.0F) return mean;
    mean.sigma_m /= weights;
    mean.num_observations = static_cast<std::uint32_t>(std::lround(count / weights));
    mean.has_color = color_weight > 0.0F;
    if (mean.has_color)
        for (int channel = 0; channel < 3; ++channel)
            mean.color[channel] =
                static_cast<std::uint8_t>(std::lround(color[channel] / color_weight));
    return mean;
}

Eigen::Vector3f FieldReader::edge_normal(int level,
                                         const Eigen::Vector3i& sample,
                                         int axis,
                                         float fraction) const {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (int around = 0; around < 4; ++around) {
        Eigen::Vector3f place = fraction * Eigen::Vector3f::Unit(axis);
        Eigen::Vector3i cell = sample;
        for (int side = 0; side < 2; ++side) {
            if (((around >> side) & 1) == 0) continue;
            cell[(axis + 1 + side) % 3] -= 1;
            place[(axis + 1 + side) % 3] = 1.0F;
        }
        std::array<float, 8> corners;
        if (read_cell(level, cell, corners)) sum += cell_at(corners, place).gradient_m;
    }
    const float length = sum.norm();
    return length > 0.0F ? Eigen::Vector3f(sum / length) : Eigen::Vector3f::UnitZ();
}

int sign_mask(const std::array<float, 8>& corners_m) {
    int mask = 0;
    for (int corner = 0; corner < 8; ++corner) mask |= (corners_m[corner] < 0.0F ? 1 : 0) << corner;
    return mask;
}

CellPoint cell_at(const std::array<float, 8>& corners_m, const Eigen::Vector3f& place) {
    const float x = place.x(), y = place.y(), z = place.z();
    float along_x[4], slope_x[4];  // of the edges along x, by y and z
    for (std::size_t i = 0; i < 4; ++i) {
        slope_x[i] = corners_m[2 * i + 1] - corners_m[2 * i];
        along_x[i] = corners_m[2 * i] + x * slope_x[i];
    }
    const float front = between(along_x[0], along_x[1], y);
    const float back = between(along_x[2], along_x[3], y);
    CellPoint point;
    point.distance_m = between(front, back, z);
    point.gradient_m.x() =
        between(between(slope_x[0], slope_x[1], y), between(slope_x[2], slope_x[3], y), z);
    point.gradient_m.y() = between(along_x[1] - along_x[0], along_x[3] - along_x[2], z);
    point.gradient_m.z() = back - front;
    return point;
}

}  // namespace divemesh::mesh
