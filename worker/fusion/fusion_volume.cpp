#include "worker/fusion/fusion_volume.hpp"

#include <cmath>

#include "schemas/error.hpp"
#include "worker/fusion/octree_volume.hpp"
#include "worker/fusion/tsdf_volume.hpp"
#include "worker/fusion/volume_file.hpp"
#include "worker/fusion/voxel_size.hpp"

namespace divemesh::fusion {

double VolumeSettings::median_voxel_m() const {
    return std::ldexp(voxel_m, levels->median_level());
}

void Volume::integrate(const types::Keyframe& keyframe, const types::KeyframeImages& images) {
    const Sampling sampling =
        choose_sampling(settings_.rig, images.depth, settings_.median_voxel_m());
    add(keyframe, DepthView(settings_.rig, images, sampling));
}

VolumeSettings choose_settings(const types::RectifiedRig& rig,
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
    return settings;
}

std::unique_ptr<Volume> make_volume(VolumeSettings settings, const ReconstructionOptions& options) {
    if (options.fusion == "octree") return std::make_unique<OctreeVolume>(std::move(settings));
    return std::make_unique<TsdfVolume>(std::move(settings));
}

std::unique_ptr<OctreeVolume> make_cloud(VolumeSettings settings,
                                         const ReconstructionOptions& options) {
    settings.voxel_m =
        options.cloud_spacing_m > 0.0 ? options.cloud_spacing_m : 0.5 * settings.voxel_m;
    if (options.cloud_spacing_m > 0.0) settings.levels = std::make_shared<LevelPlan>();
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
