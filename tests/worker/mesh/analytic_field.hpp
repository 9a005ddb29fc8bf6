#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "worker/fusion/signed_distance_field.hpp"

namespace divemesh::mesh {

// A signed distance given as a function, known within a band around its zero.
class AnalyticField : public fusion::SignedDistanceField {
public:
    using Distance = std::function<double(const Eigen::Vector3d&)>;

    AnalyticField(Distance distance, double voxel_m, int half_extent_blocks, double band_m = 1e9)
        : distance_(std::move(distance)), voxel_m_(voxel_m), band_m_(band_m) {
        for (int z = -half_extent_blocks; z < half_extent_blocks; ++z)
            for (int y = -half_extent_blocks; y < half_extent_blocks; ++y)
                for (int x = -half_extent_blocks; x < half_extent_blocks; ++x)
                    blocks_.push_back({x, y, z});
        std::sort(blocks_.begin(), blocks_.end());
    }

    double voxel_m() const override { return voxel_m_; }
    const std::vector<fusion::BlockCoordinate>& blocks() const override { return blocks_; }
    void read_distances(std::size_t block, float* distances_m) const override {
        for (int i = 0; i < fusion::kBlockSamples; ++i) distances_m[i] = distance_m(block, i);
    }
    float distance_m(std::size_t block, int i) const override {
        const Eigen::Vector3i sample =
            fusion::first_sample(blocks_[block]) + Eigen::Vector3i(i & 7, (i >> 3) & 7, i >> 6);
        const double distance = distance_(voxel_m_ * sample.cast<double>());
        return std::abs(distance) < band_m_ ? static_cast<float>(distance)
                                            : fusion::kUnknownDistance;
    }
    fusion::SampleAttributes attributes(std::size_t, int) const override {
        return {{10, 20, 30}, true, sigma_m, 5};
    }

    float sigma_m = 0.0F;

private:
    Distance distance_;
    double voxel_m_;
    double band_m_;
    std::vector<fusion::BlockCoordinate> blocks_;
};

inline AnalyticField::Distance sphere(const Eigen::Vector3d& center, double radius) {
    return [=](const Eigen::Vector3d& p) { return (p - center).norm() - radius; };
}

}  // namespace divemesh::mesh
