#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "schemas/reconstruction_options.hpp"
#include "worker/fusion/depth_view.hpp"
#include "worker/fusion/signed_distance_field.hpp"
#include "worker/fusion/spill_store.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/mesh.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::fusion {

class OctreeVolume;

struct VolumeSettings {
    types::RectifiedRig rig;
    double voxel_m = 0.01;
    double max_depth_m = 4.0;
    int num_threads = 0;  // 0: all cores; never changes a byte of the volume
    SpillSettings spill;
};

// Step 7: what the keyframes saw, brought together in the world frame: an octree of points (the
// paper) or a sparse truncated signed distance field, by `options.fusion`.
class Volume {
public:
    explicit Volume(VolumeSettings settings) : settings_(std::move(settings)) {}
    virtual ~Volume() = default;

    virtual void add(const types::Keyframe& keyframe, const DepthView& depth) = 0;
    // The same from what the keyframe store holds.
    void integrate(const types::Keyframe& keyframe, const types::KeyframeImages& images);
    // Whether enough views agree that there is a surface at each of these points: 1 or 0.
    // Neighbours one after the other are found quickly. Safe from several threads.
    virtual void confirm(std::span<const Eigen::Vector3d> p_world, std::uint8_t* out) const = 0;
    // What step 8 makes the mesh of; may not outlive the volume, nor be used while it integrates.
    virtual std::unique_ptr<SignedDistanceField> field(int num_threads) const = 0;
    virtual void save(const std::filesystem::path& file) const = 0;
    virtual std::int64_t memory_bytes() const = 0;  // what is on disk does not count
    virtual void trim() const = 0;                  // lets go of what exceeds settings().spill
    double voxel_m() const { return settings_.voxel_m; }
    const VolumeSettings& settings() const { return settings_; }

protected:
    VolumeSettings settings_;
};

// `options.voxel_m` and `max_depth_m` of 0 are chosen from the rig and `median_depth_m`. What
// exceeds `options.fusion_memory_bytes` goes to `scratch`; empty: nothing does.
std::unique_ptr<Volume> make_volume(const types::RectifiedRig& rig,
                                    const ReconstructionOptions& options,
                                    double median_depth_m,
                                    const std::filesystem::path& scratch = {});
// The octree of the points themselves, at `options.cloud_spacing_m`, beside a volume of `settings`.
std::unique_ptr<OctreeVolume> make_cloud(VolumeSettings settings,
                                         const ReconstructionOptions& options);
// Throws Error{BadData} when the file is not one of ours or is cut short.
std::unique_ptr<Volume> load_volume(const std::filesystem::path& file,
                                    const SpillSettings& spill = {});

// Two and a half pixels at the median depth, or the depth's own standard deviation there where that
// is more, to the millimetre: about 1 cm at 2 m for a rig of 500 px and 12 cm.
double choose_voxel_m(const types::RectifiedRig& rig, double median_depth_m);
// Where the depth's standard deviation reaches six voxels: beyond, a view says too little. With
// four a sixth of the tank within 10 mm is lost, with nine nothing is won.
double choose_max_depth_m(const types::RectifiedRig& rig, double voxel_m);

}  // namespace divemesh::fusion
