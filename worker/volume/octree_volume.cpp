#include "worker/volume/octree_volume.hpp"

#include <algorithm>

#include "worker/volume/depth_view.hpp"
#include "worker/volume/point_field.hpp"
#include "worker/volume/volume_file.hpp"

namespace divemesh::worker {
namespace {

constexpr int kLeastViews = 2;  // of a leaf before it counts: what one view saw may be snow

}  // namespace

OctreeVolume::OctreeVolume(VolumeSettings settings)
    : Volume(std::move(settings)), octree_(settings_.voxel_m, settings_.spill) {}

// Every pixel of the keyframe is a point: where the view has one for four of them, on its plane.
void OctreeVolume::add(const Keyframe& keyframe, const DepthView& depth) {
    const RectifiedRig& rig = settings_.rig;
    const Eigen::Matrix3f R_world_cam = keyframe.T_world_cam.linear().cast<float>();
    const double sigma_scale = 1.0 / (depth.rig().focal_px * depth.rig().baseline_m);
    const int step = depth.step_px();
    for (int v = 0; v < step * depth.rig().height_px; ++v)
        for (int u = 0; u < step * depth.rig().width_px; ++u) {
            const SurfacePixel& pixel = depth.pixel(u / step, v / step);
            if (pixel.weight <= 0.0F || pixel.depth_m > settings_.max_depth_m) continue;
            const Eigen::Vector3d ray = rig.point_cam(u, v, 1.0);
            const Eigen::Map<const Eigen::Vector3f> normal(pixel.normal);
            const double z = pixel.offset_m / normal.cast<double>().dot(ray);
            const double sigma_z = z * z * pixel.sigma_disparity_px * sigma_scale;
            const auto& bgr = depth.picture().at<cv::Vec3b>(v, u);
            PointObservation point;
            point.p_world = keyframe.T_world_cam * (z * ray);
            point.normal = -(R_world_cam * normal);
            point.color = {bgr[2], bgr[1], bgr[0]};
            point.weight = static_cast<float>(pixel.weight / (sigma_z * sigma_z));
            point.view = static_cast<std::uint8_t>(num_views_);
            octree_.insert(point);
        }
    octree_.trim();
    ++num_views_;
}

bool OctreeVolume::confirms(const Eigen::Vector3d& p_world) const {
    const Eigen::Vector3i cell = (p_world / settings_.voxel_m).array().floor().cast<int>();
    const PointLeaf* leaf = octree_.find(cell);
    return leaf != nullptr && leaf->num_views >= least_views();
}

int OctreeVolume::least_views() const {
    return std::min(kLeastViews, static_cast<int>(num_views_));
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

std::unique_ptr<OctreeVolume> OctreeVolume::load(BinaryReader& file, SpillSettings spill) {
    VolumeSettings settings = get_volume_settings(file);
    settings.spill = std::move(spill);
    auto volume = std::make_unique<OctreeVolume>(settings);
    volume->num_views_ = file.get<std::uint32_t>();
    const auto num_leaves = file.get<std::int64_t>();
    for (std::int64_t i = 0; i < num_leaves && file.ok(); ++i) {
        Eigen::Vector3i cell;
        for (int axis = 0; axis < 3; ++axis) cell[axis] = file.get<int>();
        volume->octree_.restore(cell, file.get<PointLeaf>());
    }
    return volume;
}

}  // namespace divemesh::worker
