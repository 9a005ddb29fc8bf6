#pragma once

#include <array>
#include <memory>
#include <vector>

#include "worker/fusion/point_octree.hpp"
#include "worker/fusion/signed_distance_field.hpp"

namespace divemesh::fusion {

// The signed distance to oriented points (Hoppe et al. 1992): at each sample the mean of the
// distances to the tangent planes of the leaves within 2.5 leaves, weighted by their certainty and
// nearness. A sample is known if some leaf lies within a leaf's edge of the sample's projection
// onto that leaf's plane.
class PointField : public SignedDistanceField {
public:
    PointField(const PointOctree& octree, int min_views, int num_threads);

    double voxel_m() const override { return voxel_m_; }
    const std::vector<BlockCoordinate>& blocks() const override { return coordinates_; }
    void read_distances(std::size_t block, float* distances_m) const override;
    float distance_m(std::size_t block, int sample) const override;
    SampleAttributes attributes(std::size_t block, int sample) const override;

private:
    struct Point {  // in voxels, from the first sample of its block
        Eigen::Vector3f place;
        Eigen::Vector3f normal;
        float weight;
        types::Color color;
        std::uint8_t num_views;
    };
    struct Block {
        std::array<float, kBlockSamples> distance_m;
        std::array<float, kBlockSamples> sigma_m;
        std::array<types::Color, kBlockSamples> color;
        std::array<std::uint8_t, kBlockSamples> num_views;
    };
    struct PointRange {  // of the points of one block
        std::size_t begin = 0;
        std::size_t end = 0;
    };
    class Sums;

    void collect_points(const PointOctree& octree, int min_views);
    void choose_blocks();
    void fill_block(std::size_t block);

    double voxel_m_;
    std::vector<Point> points_;
    std::vector<std::pair<BlockCoordinate, PointRange>> ranges_;  // sorted by block
    std::vector<BlockCoordinate> coordinates_;
    std::vector<std::unique_ptr<Block>> blocks_;
};

}  // namespace divemesh::fusion
