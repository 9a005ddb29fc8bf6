#include "worker/fusion/point_field.hpp"

#include <algorithm>
#include <cmath>

#include "worker/base/parallel.hpp"
#include "worker/fusion/packed_values.hpp"

namespace divemesh::fusion {
namespace {

constexpr float kRadius_voxels = 2.5F;
constexpr float kReach_voxels = 1.0F;  // along the surface, beyond the last point

}  // namespace

// Sums of the points near the samples of one block.
class PointField::Sums {
public:
    void add(const Point& point, const Eigen::Vector3f& place) {
        const Eigen::Array3i low = (place.array() - kRadius_voxels).ceil().cast<int>().cwiseMax(0);
        const Eigen::Array3i high =
            (place.array() + kRadius_voxels).floor().cast<int>().cwiseMin(kBlockEdge - 1);
        for (int z = low.z(); z <= high.z(); ++z)
            for (int y = low.y(); y <= high.y(); ++y)
                for (int x = low.x(); x <= high.x(); ++x)
                    add_to(sample_index(x, y, z),
                           point,
                           Eigen::Vector3f(Eigen::Vector3i(x, y, z).cast<float>() - place));
    }

    // Returns false if the points reach no sample.
    bool write(float voxel_m, Block& out) const {
        bool any = false;
        for (int i = 0; i < kBlockSamples; ++i) {
            out.distance_m[i] = kUnknownDistance;
            if (!reached_[i] || weight_[i] <= 0.0F) continue;
            any = true;
            out.distance_m[i] = voxel_m * distance_[i] / weight_[i];
            out.sigma_m[i] = 1.0F / std::sqrt(weight_[i]);
            for (int channel = 0; channel < 3; ++channel) {
                const float shifted = color_[i][channel] / weight_[i] + 0.5F;
                out.color[i][channel] = static_cast<std::uint8_t>(shifted);
            }
            out.num_views[i] = num_views_[i];
        }
        return any;
    }

private:
    void add_to(int sample, const Point& point, const Eigen::Vector3f& offset) {
        const float squared = offset.squaredNorm();
        if (squared >= kRadius_voxels * kRadius_voxels) return;
        const float nearness = 1.0F - squared / (kRadius_voxels * kRadius_voxels);
        const float weight = point.weight * nearness * nearness;
        const float distance = point.normal.dot(offset);
        weight_[sample] += weight;
        distance_[sample] += weight * distance;
        for (int channel = 0; channel < 3; ++channel)
            color_[sample][channel] += weight * static_cast<float>(point.color[channel]);
        num_views_[sample] = std::max(num_views_[sample], point.num_views);
        if (squared - distance * distance < kReach_voxels * kReach_voxels) reached_[sample] = true;
    }

    std::array<float, kBlockSamples> weight_{};
    std::array<float, kBlockSamples> distance_{};
    std::array<std::array<float, 3>, kBlockSamples> color_{};
    std::array<std::uint8_t, kBlockSamples> num_views_{};
    std::array<bool, kBlockSamples> reached_{};
};

PointField::PointField(const PointOctree& octree, int min_views, int num_threads)
    : voxel_m_(octree.leaf_m()) {
    collect_points(octree, min_views);
    choose_blocks();
    blocks_.resize(coordinates_.size());
    base::for_each_index(num_threads, blocks_.size(), [this](std::size_t i) { fill_block(i); });
    std::size_t num = 0;
    for (std::size_t i = 0; i < blocks_.size(); ++i)
        if (blocks_[i]) {
            coordinates_[num] = coordinates_[i];
            blocks_[num++] = std::move(blocks_[i]);
        }
    coordinates_.resize(num);
    blocks_.resize(num);
}

void PointField::collect_points(const PointOctree& octree, int min_views) {
    octree.for_each([&](const Eigen::Vector3i& cell, const PointLeaf& leaf) {
        const Eigen::Vector3f normal = leaf_normal(leaf);
        if (leaf.num_views < min_views || normal.norm() < 0.1F) return;
        const BlockCoordinate block = block_of(cell);
        if (ranges_.empty() || ranges_.back().first != block)
            ranges_.push_back({block, {points_.size(), points_.size()}});
        const Eigen::Vector3d place =
            octree.position(cell, leaf) / voxel_m_ - first_sample(block).cast<double>();
        points_.push_back({place.cast<float>(),
                           normal.normalized(),
                           unpack_weight(leaf.weight),
                           leaf_color(leaf),
                           leaf.num_views});
        ranges_.back().second.end = points_.size();
    });
    std::sort(ranges_.begin(), ranges_.end(), [](const auto& a, const auto& b) {
        return a.first < b.first;
    });
}

// Chooses every block with points and its neighbours.
void PointField::choose_blocks() {
    for (const auto& [block, range] : ranges_)
        for (int n = 0; n < 27; ++n)
            coordinates_.push_back(block + BlockCoordinate{n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1});
    std::sort(coordinates_.begin(), coordinates_.end());
    coordinates_.erase(std::unique(coordinates_.begin(), coordinates_.end()), coordinates_.end());
}

void PointField::fill_block(std::size_t block) {
    Sums sums;
    bool any = false;
    for (int n = 0; n < 27; ++n) {
        const BlockCoordinate offset{n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
        const BlockCoordinate neighbour = coordinates_[block] + offset;
        const auto range = std::lower_bound(
            ranges_.begin(), ranges_.end(), neighbour, [](const auto& entry, const auto& wanted) {
                return entry.first < wanted;
            });
        if (range == ranges_.end() || range->first != neighbour) continue;
        const Eigen::Vector3f shift = first_sample(offset).cast<float>();
        for (std::size_t i = range->second.begin; i < range->second.end; ++i) {
            const Eigen::Vector3f place = points_[i].place + shift;
            if ((place.array() < -kRadius_voxels).any() ||
                (place.array() > kBlockEdge - 1 + kRadius_voxels).any())
                continue;
            sums.add(points_[i], place);
            any = true;
        }
    }
    if (!any) return;
    auto made = std::make_unique<Block>();
    if (sums.write(static_cast<float>(voxel_m_), *made)) blocks_[block] = std::move(made);
}

void PointField::read_distances(std::size_t block, float* distances_m) const {
    std::copy(blocks_[block]->distance_m.begin(), blocks_[block]->distance_m.end(), distances_m);
}

float PointField::distance_m(std::size_t block, int sample) const {
    return blocks_[block]->distance_m[sample];
}

SampleAttributes PointField::attributes(std::size_t block, int sample) const {
    const Block& values = *blocks_[block];
    if (std::isnan(values.distance_m[sample])) return {};
    return {values.color[sample], true, values.sigma_m[sample], values.num_views[sample]};
}

}  // namespace divemesh::fusion
