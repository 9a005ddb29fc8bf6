#include "worker/mesh/block_surroundings.hpp"

#include <algorithm>
#include <cmath>

#include "worker/mesh/refined_topology.hpp"

namespace divemesh::mesh {
namespace {

constexpr int kNumCubes = 4;  // along an axis
constexpr std::size_t kNone = FieldReader::kNone;

// Extrapolated distances are beyond this. Nearer ones are holes, and stay unknown.
constexpr double kMinExtrapolated_voxels = 1.0;

int cube_index(const Eigen::Vector3i& cube) {
    return (cube.z() * kNumCubes + cube.y()) * kNumCubes + cube.x();
}

template <typename Visit>
void for_each_offset(const Visit& visit) {
    for (int z = -1; z <= 1; ++z)
        for (int y = -1; y <= 1; ++y)
            for (int x = -1; x <= 1; ++x) visit(Eigen::Vector3i(x, y, z));
}

// Visits the half-size cubes of the table that lie in the block at `offset`.
template <typename Visit>
void for_each_cube(const Eigen::Vector3i& offset, const Visit& visit) {
    const auto begin = [&](int axis) { return offset[axis] < 0 ? 0 : offset[axis] == 0 ? 1 : 3; };
    const auto end = [&](int axis) { return offset[axis] < 0 ? 1 : offset[axis] == 0 ? 3 : 4; };
    for (int z = begin(2); z < end(2); ++z)
        for (int y = begin(1); y < end(1); ++y)
            for (int x = begin(0); x < end(0); ++x) visit(Eigen::Vector3i(x, y, z));
}

bool is_odd(int coordinate) { return (coordinate & 1) != 0; }

bool has_odd(const Eigen::Vector3i& point) {
    return is_odd(point.x()) || is_odd(point.y()) || is_odd(point.z());
}

}  // namespace

BlockSurroundings::BlockSurroundings(const FieldReader& reader, std::size_t block)
    : reader_(reader),
      block_(block),
      level_(level_of(block)),
      first_sample_(fusion::first_sample(reader.field().blocks()[block])),
      first_finer_(2 * first_sample_ - Eigen::Vector3i::Constant(fusion::kBlockEdge)) {
    blocks_.fill(kNone);
    const fusion::BlockCoordinate& here = reader.field().blocks()[block];
    for_each_offset([&](const Eigen::Vector3i& offset) {
        const fusion::BlockCoordinate at =
            here + fusion::BlockCoordinate{offset.x(), offset.y(), offset.z()};
        std::size_t found = offset.isZero() ? block : reader_.find(at);
        if (found == kNone && level_ < reader_.max_level()) found = reader_.find(at.parent());
        if (found != kNone)
            add(found, offset);
        else if (level_ > reader_.min_level())
            add_finer(at, offset);
    });
}

void BlockSurroundings::add(std::size_t block, const Eigen::Vector3i& offset) {
    for_each_cube(offset, [&](const Eigen::Vector3i& cube) { blocks_[cube_index(cube)] = block; });
    if (level_of(block) != level_) one_level_ = false;
}

void BlockSurroundings::add_finer(const fusion::BlockCoordinate& coarse,
                                  const Eigen::Vector3i& offset) {
    for_each_cube(offset, [&](const Eigen::Vector3i& cube) {
        const Eigen::Vector3i part(
            is_odd(cube.x()) ? 0 : 1, is_odd(cube.y()) ? 0 : 1, is_odd(cube.z()) ? 0 : 1);
        const std::size_t found = reader_.find({2 * coarse.x + part.x(),
                                                2 * coarse.y + part.y(),
                                                2 * coarse.z + part.z(),
                                                level_ - 1});
        if (found == kNone) return;
        blocks_[cube_index(cube)] = found;
        one_level_ = false;
    });
}

std::size_t BlockSurroundings::find(int level, const Eigen::Vector3i& sample) const {
    const Eigen::Vector3i from_first = point_at(level, sample, level_ - 1) - first_finer_;
    if (from_first.minCoeff() < 0 || from_first.maxCoeff() >= kNumCubes * fusion::kBlockEdge)
        return reader_.find_any(level, sample);
    return blocks_[cube_index(point_at(0, from_first, 3))];
}

float BlockSurroundings::distance_m(const Eigen::Vector3i& sample) const {
    if (touches_coarser(level_, sample))
        if (const float mean = mean_of_coarser_m(level_, sample, 3); !std::isnan(mean)) return mean;
    return known_or_extrapolated_m(level_, sample);
}

std::array<float, 8> BlockSurroundings::read_cell(const Eigen::Vector3i& cell) const {
    std::array<float, 8> corners_m;
    for (int corner = 0; corner < 8; ++corner)
        corners_m[corner] = distance_m(cell + corner_offset(corner));
    return corners_m;
}

void BlockSurroundings::read(BlockNeighbourhood& out) const {
    std::array<float, fusion::kBlockSamples> own;
    reader_.field().read_distances(block_, own.data());
    const auto is_inside = [](int i) { return i > 0 && i < fusion::kBlockEdge; };
    for (int z = 0; z <= fusion::kBlockEdge; ++z)
        for (int y = 0; y <= fusion::kBlockEdge; ++y)
            for (int x = 0; x <= fusion::kBlockEdge; ++x)
                out.distances_m[BlockNeighbourhood::index(x, y, z)] =
                    is_inside(x) && is_inside(y) && is_inside(z)
                        ? own[fusion::sample_index(x, y, z)]
                        : distance_m(first_sample_ + Eigen::Vector3i(x, y, z));
}

std::uint32_t BlockSurroundings::split_nodes(const Eigen::Vector3i& cell) const {
    std::uint32_t nodes = 0;
    for_each_offset([&](const Eigen::Vector3i& offset) {
        const int num_axes = offset.cwiseAbs().sum();
        if (num_axes == 0 || num_axes == 3) return;  // itself, or it touches only a corner
        const std::size_t block = find(level_, cell + offset);
        if (block != kNone && level_of(block) < level_) nodes |= nodes_towards(offset);
    });
    return nodes;
}

bool BlockSurroundings::touches_finer(int level, const Eigen::Vector3i& sample) const {
    for (int corner = 0; corner < 8; ++corner) {
        const std::size_t block = find(level, sample - corner_offset(corner));
        if (block != kNone && level_of(block) < level) return true;
    }
    return false;
}

// Returns whether the point is in the middle of an edge or a face of a coarser cell.
bool BlockSurroundings::touches_coarser(int level, const Eigen::Vector3i& sample) const {
    if (!has_odd(sample)) return false;
    for (int corner = 0; corner < 8; ++corner) {
        const std::size_t block = find(level, sample - corner_offset(corner));
        if (block != kNone && level_of(block) > level) return true;
    }
    return false;
}

// Returns the sample of any level that lies at the point.
float BlockSurroundings::sample_m(int level, const Eigen::Vector3i& sample) const {
    const std::size_t block = find(level, sample);
    if (block == kNone) return fusion::kUnknownDistance;
    const int other = level_of(block);
    const Eigen::Vector3i point = point_at(level, sample, other);
    if (point_at(other, point, level) != sample) return fusion::kUnknownDistance;
    return reader_.field().distance_m(block, fusion::index_in_block(point));
}

float BlockSurroundings::known_or_extrapolated_m(int level, const Eigen::Vector3i& sample) const {
    const float known = sample_m(level, sample);
    if (!std::isnan(known)) return known;
    const std::size_t block = find(level, sample);
    const bool is_hole = block != kNone && level_of(block) >= level;
    return is_hole || !touches_finer(level, sample) ? known : extrapolated_m(level, sample);
}

// Returns the mean of linear extrapolations along the axes, in steps of this level and of the finer
// one.
float BlockSurroundings::extrapolated_m(int level, const Eigen::Vector3i& sample) const {
    float sum = 0.0F;
    int num = 0;
    for (int finer = 0; finer < 2; ++finer) {
        const int at = level - finer;
        const Eigen::Vector3i point = point_at(level, sample, at);
        for (int axis = 0; axis < 3; ++axis)
            for (const int side : {-1, 1}) {
                const Eigen::Vector3i step = side * Eigen::Vector3i::Unit(axis);
                const float here =
                    2.0F * sample_m(at, point + step) - sample_m(at, point + 2 * step);
                if (std::isnan(here)) continue;
                sum += here;
                ++num;
            }
    }
    if (num == 0) return fusion::kUnknownDistance;
    const float mean = sum / static_cast<float>(num);
    const auto min_m = static_cast<float>(kMinExtrapolated_voxels * reader_.step_m(level));
    return std::abs(mean) >= min_m ? mean : fusion::kUnknownDistance;
}

// Returns the mean of the nearest points that the coarser level has too. Halves along one axis
// after another, as RefinedTopology does, so that no rounding makes a difference.
float BlockSurroundings::mean_of_coarser_m(int level,
                                           const Eigen::Vector3i& sample,
                                           int num_axes) const {
    if (num_axes == 0)
        return known_or_extrapolated_m(level + 1, point_at(level, sample, level + 1));
    const int axis = num_axes - 1;
    if (!is_odd(sample[axis])) return mean_of_coarser_m(level, sample, axis);
    const Eigen::Vector3i step = Eigen::Vector3i::Unit(axis);
    return 0.5F * (mean_of_coarser_m(level, sample - step, axis) +
                   mean_of_coarser_m(level, sample + step, axis));
}

}  // namespace divemesh::mesh
