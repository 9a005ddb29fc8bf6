#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "worker/base/binary_file.hpp"
#include "worker/fusion/block_coordinate.hpp"
#include "worker/fusion/fusion_volume.hpp"
#include "worker/fusion/spill_store.hpp"
#include "worker/fusion/tsdf_block.hpp"
#include "worker/fusion/update_block.hpp"
#include "worker/fusion/visible_blocks.hpp"

namespace divemesh::fusion {

// Truncated signed distances (Curless and Levoy 1996) in blocks that exist only near the surface.
// The distance of a view is to its tangent plane. Its weight is one over the variance of the depth
// that it measures at the sample's own range, sigma_z = z^2 sigma_d / (f b), which avoids a bias
// toward far readings, times a ramp at depth discontinuities and the cosine of incidence. Samples
// are truncated at the larger of three voxels and two sigma. Views whose surface is farther behind
// a sample than three voxels and four sigma carve the sample with the same weight, which removes
// objects that only a few views saw there, such as snow or fish. A place is sampled by the blocks
// of its level in the plan; views too far away for that level only carve. Blocks that were not in
// view lately are spilled to disk.
class TsdfVolume : public Volume {
public:
    explicit TsdfVolume(VolumeSettings settings);

    void add(const types::Keyframe& keyframe, const DepthView& depth) override;
    void confirm(std::span<const Eigen::Vector3d> p_world, std::uint8_t* out) const override;
    std::unique_ptr<SignedDistanceField> field(int num_threads) const override;
    void save(const std::filesystem::path& file) const override;
    std::int64_t memory_bytes() const override;
    void trim() const override { samples_.trim(); }

    static std::unique_ptr<TsdfVolume> load(base::BinaryReader& file, SpillSettings spill);

private:
    friend class TsdfField;

    // `views` are those of one keyframe, one per level.
    void allocate(std::span<const TsdfView> views,
                  const types::Keyframe& keyframe,
                  const DepthView& depth);
    // Counts a pixel. Returns whether it may make surface at any level.
    bool count(const TsdfView& coarsest, const SurfacePixel& pixel);
    void update(const TsdfView& view, const BlockRegions& regions);
    void add_block(const BlockCoordinate& block);
    TsdfBlock& block(std::uint32_t number);
    const TsdfBlock& block(std::uint32_t number) const;

    // Returns true if a sample is certain enough to be surface: enough views saw it, or one that
    // no other frame could have confirmed, and its sigma is small enough for its level.
    bool is_confirmed(const TsdfBlock& samples, int i, int level) const;

    // Two, as surface that is far away or at the border of a dive has depth in only two views: with
    // three, 4 % of the reference within 10 mm are lost on tank and barge.
    static constexpr std::uint32_t kMinViews = 2;
    std::uint32_t num_views_ = 0;
    std::vector<float> min_weight_;             // by level
    std::vector<BlockCoordinate> coordinates_;  // in the order of allocation
    std::vector<BlockRegions> regions_;         // the same blocks, by level and position
    std::vector<SpillStore::Handle> blocks_;
    SpillStore samples_;
    std::unordered_map<BlockCoordinate, std::uint32_t, BlockCoordinateHash> index_;
};

}  // namespace divemesh::fusion
