#pragma once

#include <deque>
#include <memory>

#include "worker/base/binary_file.hpp"
#include "worker/fusion/point_octree.hpp"
#include "worker/fusion/recent_blocks.hpp"
#include "worker/fusion/tsdf_volume.hpp"

namespace divemesh::fusion {

// The paper's step 7: every point that a keyframe saw goes into an octree, which keeps the weighted
// mean of each leaf. Its surface is the zero of the signed distance to the tangent planes of the
// leaves (Hoppe et al. 1992), averaged over the leaves nearby. With several levels there is an
// octree for each, of leaves half a voxel wide, which holds the points of the places planned for
// it; these make no surface.
class OctreeVolume : public Volume {
public:
    explicit OctreeVolume(VolumeSettings settings);

    void add(const types::Keyframe& keyframe, const DepthView& depth) override;
    void confirm(std::span<const Eigen::Vector3d> p_world, std::uint8_t* out) const override;
    std::unique_ptr<SignedDistanceField> field(int num_threads) const override;
    void save(const std::filesystem::path& file) const override;
    std::int64_t memory_bytes() const override;
    void trim() const override;

    // The octrees of the levels, the finest first; their leaves lie in different places.
    const std::deque<PointOctree>& octrees() const { return octrees_; }

    static std::unique_ptr<OctreeVolume> load(base::BinaryReader& file, SpillSettings spill);

private:
    int min_views() const;
    void insert_four(const Eigen::Isometry3d& T_world_cam,
                     const DepthView& depth,
                     const Eigen::Vector2i& at,
                     PointObservation point);

    PointOctree& octree_at(const Eigen::Vector3d& p_world);

    std::deque<PointOctree> octrees_;
    RecentBlocks recent_;
    std::uint32_t num_views_ = 0;
};

}  // namespace divemesh::fusion
