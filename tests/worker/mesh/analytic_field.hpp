#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <vector>

#include "worker/fusion/signed_distance_field.hpp"

namespace divemesh::mesh {

// A signed distance given as a function, known within a band around its zero.
class AnalyticField : public fusion::SignedDistanceField {
public:
    using Distance = std::function<double(const Eigen::Vector3d&)>;
    // Returns whether a block is to be split into finer ones.
    using Splits =
        std::function<bool(const fusion::BlockCoordinate& block, const Eigen::Vector3d& middle)>;

    AnalyticField(Distance distance, double voxel_m, int half_extent_blocks, double band_m = 1e9)
        : distance_(std::move(distance)),
          voxel_m_(voxel_m),
          band_([=](int) { return band_m; }),
          blocks_(cube_of_blocks(half_extent_blocks, 0)) {}

    // Makes blocks of several levels. Splits blocks of level `coarsest` down to level 0 where
    // `splits` returns true, and further until blocks that touch differ by one level at most.
    // Leaves out blocks without a known sample.
    AnalyticField(Distance distance,
                  double voxel_m,
                  int half_extent_blocks,
                  int coarsest,
                  const Splits& splits,
                  double band_voxels = 1e9)
        : distance_(std::move(distance)),
          voxel_m_(voxel_m),
          band_([=](int level) { return band_voxels * std::ldexp(voxel_m, level); }) {
        std::vector<fusion::BlockCoordinate> open = cube_of_blocks(half_extent_blocks, coarsest);
        std::set<fusion::BlockCoordinate> leaves;
        while (!open.empty()) {
            const fusion::BlockCoordinate block = open.back();
            open.pop_back();
            if (block.level > 0 && splits(block, middle(block)))
                for (const auto& part : parts(block)) open.push_back(part);
            else
                leaves.insert(block);
        }
        balance(leaves);
        blocks_.assign(leaves.begin(), leaves.end());
        std::vector<fusion::BlockCoordinate> known;
        for (std::size_t block = 0; block < blocks_.size(); ++block)
            for (int i = 0; i < fusion::kBlockSamples; ++i)
                if (!std::isnan(distance_m(block, i))) {
                    known.push_back(blocks_[block]);
                    break;
                }
        blocks_ = known;
    }

    double voxel_m() const override { return voxel_m_; }
    const std::vector<fusion::BlockCoordinate>& blocks() const override { return blocks_; }
    void read_distances(std::size_t block, float* distances_m) const override {
        for (int i = 0; i < fusion::kBlockSamples; ++i) distances_m[i] = distance_m(block, i);
    }
    float distance_m(std::size_t block, int i) const override {
        const Eigen::Vector3i sample =
            fusion::first_sample(blocks_[block]) + Eigen::Vector3i(i & 7, (i >> 3) & 7, i >> 6);
        const int level = blocks_[block].level;
        const double distance = distance_(std::ldexp(voxel_m_, level) * sample.cast<double>());
        return std::abs(distance) < band_(level) ? static_cast<float>(distance)
                                                 : fusion::kUnknownDistance;
    }
    fusion::SampleAttributes attributes(std::size_t, int) const override {
        return {{10, 20, 30}, true, sigma_m, 5};
    }

    float sigma_m = 0.0F;

private:
    static std::vector<fusion::BlockCoordinate> cube_of_blocks(int half_extent, int level) {
        std::vector<fusion::BlockCoordinate> blocks;
        for (int x = -half_extent; x < half_extent; ++x)
            for (int y = -half_extent; y < half_extent; ++y)
                for (int z = -half_extent; z < half_extent; ++z) blocks.push_back({x, y, z, level});
        return blocks;
    }
    Eigen::Vector3d middle(const fusion::BlockCoordinate& block) const {
        return std::ldexp(voxel_m_, block.level) *
               (fusion::first_sample(block).cast<double>() + Eigen::Vector3d::Constant(4.0));
    }
    static std::vector<fusion::BlockCoordinate> parts(const fusion::BlockCoordinate& block) {
        std::vector<fusion::BlockCoordinate> parts;
        parts.reserve(8);
        for (int i = 0; i < 8; ++i)
            parts.push_back({2 * block.x + (i & 1),
                             2 * block.y + ((i >> 1) & 1),
                             2 * block.z + (i >> 2),
                             block.level - 1});
        return parts;
    }
    // Splits blocks that touch a block two or more levels finer.
    static void balance(std::set<fusion::BlockCoordinate>& leaves) {
        for (bool changed = true; changed;) {
            changed = false;
            for (const auto& block : std::vector(leaves.begin(), leaves.end()))
                for (int i = 0; i < 27; ++i) {
                    fusion::BlockCoordinate beside =
                        block + fusion::BlockCoordinate{i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
                    while (beside.level < 16 && leaves.count(beside) == 0) beside = beside.parent();
                    if (beside.level == 16 || beside.level < block.level + 2) continue;
                    leaves.erase(beside);
                    for (const auto& part : parts(beside)) leaves.insert(part);
                    changed = true;
                }
        }
    }

    Distance distance_;
    double voxel_m_;
    std::function<double(int level)> band_;
    std::vector<fusion::BlockCoordinate> blocks_;
};

inline AnalyticField::Distance sphere(const Eigen::Vector3d& center, double radius) {
    return [=](const Eigen::Vector3d& p) { return (p - center).norm() - radius; };
}

}  // namespace divemesh::mesh
