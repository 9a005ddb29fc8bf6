#include "worker/volume/octree_volume.hpp"

#include <algorithm>

#include "worker/volume/depth_view.hpp"
#include "worker/volume/point_field.hpp"
#include "worker/volume/volume_file.hpp"

namespace divemesh::worker {
namespace {

constexpr int kLeastViews = 2;  // of a leaf before it counts: what one view saw may be snow

}  // namespace

OctreeVolume::OctreeVolume(const VolumeSettings& settings)
    : settings_(settings), octree_(settings.voxel_m) {}

void OctreeVolume::integrate(const Keyframe& keyframe, const KeyframeImages& images) {
    const RectifiedRig& rig = settings_.rig;
    const DepthView depth(rig, images);
    const Eigen::Matrix3f R_world_cam = keyframe.T_world_cam.linear().cast<float>();
    const double sigma_scale = 1.0 / (rig.focal_px * rig.baseline_m);
    for (int v = 0; v < depth.height_px(); ++v)
        for (int u = 0; u < depth.width_px(); ++u) {
            const SurfacePixel& pixel = depth.pixel(u, v);
            const double z = pixel.depth_m;
            if (pixel.weight <= 0.0F || z > settings_.max_depth_m) continue;
            const double sigma_z = z * z * pixel.sigma_disparity_px * sigma_scale;
            const auto& bgr = images.left_color.at<cv::Vec3b>(v, u);
            PointObservation point;
            point.p_world = keyframe.T_world_cam * rig.point_cam(u, v, z);
            point.normal = -(R_world_cam * Eigen::Map<const Eigen::Vector3f>(pixel.normal));
            point.color = {bgr[2], bgr[1], bgr[0]};
            point.weight = static_cast<float>(pixel.weight / (sigma_z * sigma_z));
            point.view = static_cast<std::uint8_t>(num_views_);
            octree_.insert(point);
        }
    ++num_views_;
}

int OctreeVolume::least_views() const {
    return std::min(kLeastViews, static_cast<int>(num_views_));
}

PointCloud OctreeVolume::cloud() const {
    PointCloud cloud;
    octree_.for_each([&](const Eigen::Vector3i& cell, const PointLeaf& leaf) {
        if (leaf.num_views < least_views()) return;
        cloud.points.push_back(octree_.position(cell, leaf).cast<float>());
        cloud.colors.push_back(leaf_color(leaf));
    });
    return cloud;
}

std::unique_ptr<SignedField> OctreeVolume::field(int num_threads) const {
    return std::make_unique<PointField>(octree_, least_views(), num_threads);
}

void OctreeVolume::save(const std::filesystem::path& path) const {
    BinaryWriter file(path);
    put_volume_header(file, kOctreeMagic, settings_);
    file.put(num_views_);
    file.put(octree_.num_points());
    octree_.for_each([&](const Eigen::Vector3i& cell, const PointLeaf& leaf) {
        for (int axis = 0; axis < 3; ++axis) file.put(cell[axis]);
        file.put(leaf);
    });
    file.commit();
}

std::unique_ptr<OctreeVolume> OctreeVolume::load(BinaryReader& file) {
    auto volume = std::make_unique<OctreeVolume>(get_volume_settings(file));
    volume->num_views_ = file.get<std::uint32_t>();
    const auto num_leaves = file.get<std::uint32_t>();
    for (std::uint32_t i = 0; i < num_leaves && file.ok(); ++i) {
        Eigen::Vector3i cell;
        for (int axis = 0; axis < 3; ++axis) cell[axis] = file.get<int>();
        volume->octree_.restore(cell, file.get<PointLeaf>());
    }
    return volume;
}

}  // namespace divemesh::worker
