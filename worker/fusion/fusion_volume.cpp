#include "worker/fusion/fusion_volume.hpp"

#include <algorithm>
#include <cmath>

#include "schemas/error.hpp"
#include "worker/fusion/octree_volume.hpp"
#include "worker/fusion/tsdf_volume.hpp"
#include "worker/fusion/volume_file.hpp"

namespace divemesh::fusion {
namespace {

constexpr double kSigmaDisparity_px = 0.15;  // of a textured surface
constexpr double kPixelsPerVoxel = 2.5;
constexpr double kMaxSigma_voxels = 6.0;

double sigma_z(const types::RectifiedRig& rig, double depth_m) {
    return depth_m * depth_m * kSigmaDisparity_px / (rig.focal_px * rig.baseline_m);
}

}  // namespace

double choose_voxel_m(const types::RectifiedRig& rig, double median_depth_m) {
    const double depth = std::clamp(median_depth_m, 0.2, 50.0);
    const double voxel = std::max(kPixelsPerVoxel * depth / rig.focal_px, sigma_z(rig, depth));
    return std::max(0.001, std::round(voxel * 1000.0) / 1000.0);
}

double choose_max_depth_m(const types::RectifiedRig& rig, double voxel_m) {
    return std::sqrt(kMaxSigma_voxels * voxel_m / sigma_z(rig, 1.0));
}

void Volume::integrate(const types::Keyframe& keyframe, const types::KeyframeImages& images) {
    const Sampling sampling = choose_sampling(settings_.rig, images.depth, settings_.voxel_m);
    add(keyframe, DepthView(settings_.rig, images, sampling));
}

std::unique_ptr<Volume> make_volume(const types::RectifiedRig& rig,
                                    const ReconstructionOptions& options,
                                    double median_depth_m,
                                    const std::filesystem::path& scratch) {
    VolumeSettings settings;
    settings.rig = rig;
    settings.voxel_m =
        options.voxel_m > 0.0 ? options.voxel_m : choose_voxel_m(rig, median_depth_m);
    settings.max_depth_m =
        options.max_depth_m > 0.0 ? options.max_depth_m : choose_max_depth_m(rig, settings.voxel_m);
    settings.num_threads = options.num_threads;
    settings.spill = {scratch, options.fusion_memory_bytes / 2};
    if (options.fusion == "octree") return std::make_unique<OctreeVolume>(settings);
    return std::make_unique<TsdfVolume>(settings);
}

std::unique_ptr<OctreeVolume> make_cloud(VolumeSettings settings,
                                         const ReconstructionOptions& options) {
    settings.voxel_m =
        options.cloud_spacing_m > 0.0 ? options.cloud_spacing_m : 0.5 * settings.voxel_m;
    return std::make_unique<OctreeVolume>(settings);
}

std::unique_ptr<Volume> load_volume(const std::filesystem::path& path, const SpillSettings& spill) {
    base::BinaryReader file(path);
    const auto magic = file.get<std::uint32_t>();
    std::unique_ptr<Volume> volume;
    if (file.ok() && magic == kTsdfMagic) volume = TsdfVolume::load(file, spill);
    if (file.ok() && magic == kOctreeMagic) volume = OctreeVolume::load(file, spill);
    if (!volume || !file.at_end())
        throw Error(ErrorCode::BadData,
                    path.string() + " is incomplete or was written by another version: fuse again");
    return volume;
}

}  // namespace divemesh::fusion
