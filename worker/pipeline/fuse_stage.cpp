#include <cmath>
#include <memory>

#include "worker/fusion/confirmed_points.hpp"
#include "worker/io/ply.hpp"
#include "worker/pipeline/link_or_copy.hpp"
#include "worker/pipeline/stage_files.hpp"
#include "worker/pipeline/stage_functions.hpp"

namespace divemesh::pipeline {
namespace {

// Writes the cloud in a background task during meshing; everything needed from the volume is read
// before.
void write_cloud(Reconstruction& made, std::shared_ptr<const fusion::OctreeVolume> cloud) {
    const auto points = std::make_shared<const fusion::ConfirmedPoints>(
        cloud->octrees(), *made.volume, made.options().num_threads);
    made.cloud = {
        points->size(), cloud->settings().median_voxel_m(), 0, 0, made.volume->fused_pixels()};
    for (const fusion::PointOctree& octree : cloud->octrees()) {
        made.cloud.num_octree_points += octree.num_points();
        made.cloud.octree_bytes += octree.size_bytes();
    }
    made.cloud_writer.run([file = made.artifact("cloud.ply"), cloud = std::move(cloud), points] {
        io::CloudPlyWriter writer(file, points->size());
        points->for_each([&](const Eigen::Vector3f& p_world, const types::Color& color) {
            writer.add(p_world, color);
        });
        writer.commit();
    });
    if (made.options().num_threads == 1) made.cloud_writer.wait();  // frees memory for the mesh
}

}  // namespace

bool surface_wanted(const Reconstruction& made) {
    return made.options().surface && !made.has_failed();
}

bool load_fuse(Reconstruction& made, const std::string& key) {
    const auto metrics = load_cloud_metrics(made.scratch("cloud.stage"), key);
    if (!metrics || !std::filesystem::exists(made.scratch("cloud.ply")) ||
        !std::filesystem::exists(made.scratch("volume.stage")))
        return false;
    made.cloud = *metrics;
    link_or_copy(made.scratch("cloud.ply"), made.artifact("cloud.ply"));
    made.volume = fusion::load_volume(made.scratch("volume.stage"),
                                      {made.request.scratch, made.options().fusion_memory_bytes});
    return true;
}

void run_fuse(Reconstruction& made, const base::ProgressCallback& progress) {
    FusedMap map = fuse({made.optimised.rig,
                         made.optimised.mapped,
                         made.track.statistics.median_depth_m,
                         made.keyframe_store,
                         made.optimised.max_depth_m},
                        made.options(),
                        made.request.scratch,
                        progress);
    made.volume = std::move(map.volume);
    write_cloud(made, std::move(map.cloud));
}

void save_fuse(Reconstruction& made, const std::string& key) {
    made.cloud_writer.wait();
    made.volume->save(made.scratch("volume.stage"));
    link_or_copy(made.artifact("cloud.ply"), made.scratch("cloud.ply"));
    save_cloud_metrics(made.scratch("cloud.stage"), key, made.cloud);
}

void finish_fuse(Reconstruction& made) {
    const fusion::VolumeSettings& settings = made.volume->settings();
    made.voxels = {settings.median_voxel_m(),
                   settings.voxel_m,
                   std::ldexp(settings.voxel_m, settings.levels->num_levels() - 1)};
    made.max_depth_m = settings.max_depth_m;
    made.volume_memory_bytes = made.volume->memory_bytes();
}

}  // namespace divemesh::pipeline
