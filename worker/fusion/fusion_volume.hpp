#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "schemas/reconstruction_options.hpp"
#include "worker/fusion/depth_view.hpp"
#include "worker/fusion/level_plan.hpp"
#include "worker/fusion/signed_distance_field.hpp"
#include "worker/fusion/spill_store.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/mesh.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::fusion {

class OctreeVolume;

// The rig whose keyframes are fused, the sampling of space and the limits of a volume.
struct VolumeSettings {
    types::RectifiedRig rig;
    double voxel_m = 0.01;  // of level 0
    std::shared_ptr<const LevelPlan> levels = std::make_shared<LevelPlan>();
    double max_depth_m = 4.0;
    int num_threads = 0;  // 0: all cores; the volume is the same to the byte for any number
    SpillSettings spill;

    double median_voxel_m() const;  // of surface at the dive's median depth
};

// The pixels with depth of the fused frames, and those of them that make no surface anywhere.
struct FusedPixels {
    std::int64_t num = 0;
    std::int64_t num_too_far = 0;    // beyond VolumeSettings::max_depth_m
    std::int64_t num_too_vague = 0;  // nearer, but less certain than the coarsest level allows
};

// Step 7: fuses what the keyframes saw in the world frame, in an octree of points (the paper) or a
// sparse truncated signed distance field, by `options.fusion`.
class Volume {
public:
    explicit Volume(VolumeSettings settings) : settings_(std::move(settings)) {}
    virtual ~Volume() = default;

    virtual void add(const types::Keyframe& keyframe, const DepthView& depth) = 0;
    // Adds a keyframe with its images from the keyframe store.
    void integrate(const types::Keyframe& keyframe, const types::KeyframeImages& images);
    // Writes 1 to `out` for each point at which enough views agree that there is a surface, else 0.
    // It is fast if neighbours follow one another. Thread-safe.
    virtual void confirm(std::span<const Eigen::Vector3d> p_world, std::uint8_t* out) const = 0;
    // Returns the field that step 8 meshes. It may not outlive the volume, nor be used while the
    // volume integrates.
    virtual std::unique_ptr<SignedDistanceField> field(int num_threads) const = 0;
    virtual void save(const std::filesystem::path& file) const = 0;
    virtual std::int64_t memory_bytes() const = 0;        // excludes what is on disk
    virtual void trim() const = 0;                        // spills what exceeds settings().spill
    double voxel_m() const { return settings_.voxel_m; }  // of level 0
    const VolumeSettings& settings() const { return settings_; }
    // Returns the pixels that were added; a volume from a file does not know them.
    const FusedPixels& fused_pixels() const { return fused_pixels_; }

protected:
    VolumeSettings settings_;
    FusedPixels fused_pixels_;
};

// Returns settings of one level. `options.voxel_m` and `max_depth_m` of 0 are chosen from the rig
// and `median_depth_m`. Data beyond `options.fusion_memory_bytes` is spilled to `scratch`; if
// `scratch` is empty, all stays in memory.
VolumeSettings choose_settings(const types::RectifiedRig& rig,
                               const ReconstructionOptions& options,
                               double median_depth_m,
                               const std::filesystem::path& scratch = {});
// Makes the volume that `options.fusion` names.
std::unique_ptr<Volume> make_volume(VolumeSettings settings, const ReconstructionOptions& options);
// Makes an octree for the point cloud, at `options.cloud_spacing_m`, beside a volume of `settings`.
std::unique_ptr<OctreeVolume> make_cloud(VolumeSettings settings,
                                         const ReconstructionOptions& options);
// Reads a saved volume. Throws Error{BadData} if the file is not a saved volume or is truncated.
std::unique_ptr<Volume> load_volume(const std::filesystem::path& file,
                                    const SpillSettings& spill = {});

}  // namespace divemesh::fusion
