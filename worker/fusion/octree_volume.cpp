#include "worker/fusion/octree_volume.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "worker/fusion/depth_view.hpp"
#include "worker/fusion/point_field.hpp"
#include "worker/fusion/volume_file.hpp"

namespace divemesh::fusion {
namespace {

constexpr double kMaxLeaf = 1e9;  // of a lattice
constexpr int kMinViews = 2;  // a leaf counts from two views on: what only one view saw may be snow

}  // namespace

OctreeVolume::OctreeVolume(VolumeSettings settings)
    : Volume(std::move(settings)), recent_(*settings_.levels) {
    const int num_levels = settings_.levels->num_levels();
    SpillSettings spill = settings_.spill;
    spill.memory_bytes /= num_levels;
    for (int level = 0; level < num_levels; ++level)
        octrees_.emplace_back(std::ldexp(settings_.voxel_m, level), spill);
}

// If a pixel of the view stands for four of the keyframe, it is one point if all four would be in
// the same leaf, else four points on its plane, as leaves between the points would stay empty
// otherwise.
void OctreeVolume::add(const types::Keyframe& keyframe, const DepthView& depth) {
    const double sigma_scale = 1.0 / (depth.rig().focal_px * depth.rig().baseline_m);
    // The depth at which a keyframe pixel is as wide as a leaf of the median depth.
    const double pixel_is_leaf_m = settings_.median_voxel_m() * settings_.rig.focal_px;
    PointObservation point;
    point.view = static_cast<std::uint8_t>(num_views_);
    for (int v = 0; v < depth.rig().height_px; ++v)
        for (int u = 0; u < depth.rig().width_px; ++u) {
            const SurfacePixel& pixel = depth.pixel(u, v);
            if (pixel.weight <= 0.0F) continue;
            ++fused_pixels_.num;
            if (pixel.depth_m > settings_.max_depth_m) {
                ++fused_pixels_.num_too_far;
                continue;
            }
            const double z = pixel.depth_m;
            const double sigma_z = z * z * pixel.sigma_disparity_px * sigma_scale;
            const Eigen::Map<const Eigen::Vector3f> normal(pixel.normal);
            point.normal = -(keyframe.T_world_cam.linear().cast<float>() * normal);
            point.weight = static_cast<float>(pixel.weight / (sigma_z * sigma_z));
            if (depth.step_px() == 1 || depth.step_px() * z <= pixel_is_leaf_m) {
                point.p_world = keyframe.T_world_cam * depth.rig().point_cam(u, v, z);
                for (int i = 0; i < 3; ++i)
                    point.color[i] = static_cast<std::uint8_t>(pixel.color >> (16 - 8 * i));
                octree_at(point.p_world).insert(point);
            } else {
                insert_four(keyframe.T_world_cam, depth, {u, v}, point);
            }
        }
    trim();
    ++num_views_;
}

PointOctree& OctreeVolume::octree_at(const Eigen::Vector3d& p_world) {
    if (octrees_.size() == 1) return octrees_.front();
    const Eigen::Array3d leaf = p_world.array() / settings_.voxel_m;
    if (!(leaf.abs().maxCoeff() < kMaxLeaf)) return octrees_.back();
    const Eigen::Vector3i sample = (0.5 * leaf).round().matrix().cast<int>();
    return octrees_[recent_.at(sample).block.level];
}

void OctreeVolume::insert_four(const Eigen::Isometry3d& T_world_cam,
                               const DepthView& depth,
                               const Eigen::Vector2i& at,
                               PointObservation point) {
    const SurfacePixel& pixel = depth.pixel(at.x(), at.y());
    const Eigen::Map<const Eigen::Vector3f> normal(pixel.normal);
    for (int i = 0; i < 4; ++i) {
        const Eigen::Vector2i full(2 * at.x() + (i & 1), 2 * at.y() + (i >> 1));
        const Eigen::Vector3d ray = settings_.rig.point_cam(full.x(), full.y(), 1.0);
        point.p_world = T_world_cam * (pixel.offset_m / normal.cast<double>().dot(ray) * ray);
        const auto& bgr = depth.image().at<cv::Vec3b>(full.y(), full.x());
        point.color = {bgr[2], bgr[1], bgr[0]};
        octree_at(point.p_world).insert(point);
    }
}

void OctreeVolume::confirm(std::span<const Eigen::Vector3d> p_world, std::uint8_t* out) const {
    for (const Eigen::Vector3d& p : p_world) {
        const Eigen::Vector3i cell = (p / settings_.voxel_m).array().floor().cast<int>();
        const PointLeaf* leaf = octrees_.front().find(cell);
        *out++ = leaf != nullptr && leaf->num_views >= min_views();
    }
}

std::int64_t OctreeVolume::memory_bytes() const {
    return std::accumulate(
        octrees_.begin(),
        octrees_.end(),
        std::int64_t{0},
        [](std::int64_t sum, const auto& octree) { return sum + octree.memory_bytes(); });
}

void OctreeVolume::trim() const {
    for (const PointOctree& octree : octrees_) octree.trim();
}

int OctreeVolume::min_views() const { return std::min(kMinViews, static_cast<int>(num_views_)); }

std::unique_ptr<SignedDistanceField> OctreeVolume::field(int num_threads) const {
    return std::make_unique<PointField>(octrees_.front(), min_views(), num_threads);
}

void OctreeVolume::save(const std::filesystem::path& path) const {
    base::BinaryWriter file(path);
    put_volume_header(file, kOctreeMagic, settings_);
    file.put(num_views_);
    const PointOctree& octree = octrees_.front();
    file.put(octree.num_points());
    octree.for_each([&](const Eigen::Vector3i& cell, const PointLeaf& leaf) {
        for (int axis = 0; axis < 3; ++axis) file.put(cell[axis]);
        file.put(leaf);
    });
    file.commit();
}

std::unique_ptr<OctreeVolume> OctreeVolume::load(base::BinaryReader& file, SpillSettings spill) {
    VolumeSettings settings = get_volume_settings(file);
    settings.spill = std::move(spill);
    auto volume = std::make_unique<OctreeVolume>(settings);
    volume->num_views_ = file.get<std::uint32_t>();
    const auto num_leaves = file.get<std::int64_t>();
    for (std::int64_t i = 0; i < num_leaves && file.ok(); ++i) {
        Eigen::Vector3i cell;
        for (int axis = 0; axis < 3; ++axis) cell[axis] = file.get<int>();
        volume->octrees_.front().restore(cell, file.get<PointLeaf>());
    }
    return volume;
}

}  // namespace divemesh::fusion
