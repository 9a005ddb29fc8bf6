#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "schemas/reconstruction_options.hpp"
#include "worker/geometry/rectified_rig.hpp"
#include "worker/keyframe.hpp"
#include "worker/volume/mesh.hpp"
#include "worker/volume/signed_field.hpp"

namespace divemesh::worker {

// Step 7: what the keyframes saw, brought together in the world frame: an octree of points (the
// paper) or a sparse truncated signed distance field, by `options.fusion`.
class Volume {
public:
    virtual ~Volume() = default;

    virtual void integrate(const Keyframe& keyframe, const KeyframeImages& images) = 0;
    virtual PointCloud cloud() const = 0;
    // What step 8 makes the mesh of; may not outlive the volume, nor be used while it integrates.
    virtual std::unique_ptr<SignedField> field(int num_threads) const = 0;
    virtual void save(const std::filesystem::path& file) const = 0;
    virtual std::int64_t memory_bytes() const = 0;
    virtual double voxel_m() const = 0;
};

// `options.voxel_m` and `max_depth_m` of 0 are chosen from the rig and `median_depth_m`.
std::unique_ptr<Volume> make_volume(const RectifiedRig& rig,
                                    const ReconstructionOptions& options,
                                    double median_depth_m);
// Throws Error{BadData} when the file is not one of ours or is cut short.
std::unique_ptr<Volume> load_volume(const std::filesystem::path& file);

// Two and a half pixels at the median depth, or the depth's own standard deviation there where that
// is more, to the millimetre: about 1 cm at 2 m for a rig of 500 px and 12 cm.
double choose_voxel_m(const RectifiedRig& rig, double median_depth_m);
// Where the depth's standard deviation reaches four voxels: beyond, a view says too little.
double choose_max_depth_m(const RectifiedRig& rig, double voxel_m);

}  // namespace divemesh::worker
