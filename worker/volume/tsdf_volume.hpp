#pragma once

#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "worker/steps/add_points.hpp"
#include "worker/volume/block_coordinate.hpp"
#include "worker/volume/tsdf_block.hpp"
#include "worker/volume/update_block.hpp"
#include "worker/volume/visible_blocks.hpp"

namespace divemesh::worker {

struct VolumeSettings {
    RectifiedRig rig;
    double voxel_m = 0.01;
    double max_depth_m = 4.0;
    int num_threads = 0;  // 0: all cores; never changes a byte of the volume
};

// Truncated signed distances (Curless and Levoy 1996) in blocks that exist near the surface alone.
// A view's distance is to its tangent plane; its weight is one over the variance of the depth that
// it measures at the sample's own range, sigma_z = z^2 sigma_d / (f b), which leaves no bias toward
// far readings, times a ramp at depth discontinuities and the cosine of incidence. Samples are
// truncated at the larger of three voxels and three sigma. Views that look through a sample pull it
// to the front with the same weight: what was there in a few views, snow or fish, goes.
class TsdfVolume : public Volume {
public:
    explicit TsdfVolume(const VolumeSettings& settings);

    void integrate(const Keyframe& keyframe, const KeyframeImages& images) override;
    PointCloud cloud() const override;
    std::unique_ptr<SignedField> field(int num_threads) const override;
    void save(const std::filesystem::path& file) const override;
    std::int64_t memory_bytes() const override;
    double voxel_m() const override { return settings_.voxel_m; }

    static std::unique_ptr<TsdfVolume> load(class BinaryReader& file);

private:
    friend class TsdfField;

    void allocate(const TsdfView& view, const Eigen::Isometry3d& T_world_cam);
    void add_block(const BlockCoordinate& block);

    VolumeSettings settings_;
    std::uint32_t num_views_ = 0;
    std::vector<BlockCoordinate> coordinates_;  // in the order of allocation
    BlockRegions regions_;                      // the same blocks, by where they are
    std::vector<std::unique_ptr<TsdfBlock>> blocks_;
    std::unordered_map<BlockCoordinate, std::uint32_t, BlockCoordinateHash> index_;
};

}  // namespace divemesh::worker
