#include "worker/fusion/visible_blocks.hpp"

#include <algorithm>
#include <cmath>

namespace divemesh::fusion {
namespace {

constexpr float kBlockSize_samples = kBlockEdge;
constexpr float kRegionSize_samples = 8.0F * kBlockEdge;
constexpr int kLevel = 1;  // of the tiles that a block is compared with

Eigen::Vector3f middle_of(const BlockCoordinate& cube, float edge_samples, float voxel_m) {
    const Eigen::Vector3f first =
        edge_samples * Eigen::Vector3i(cube.x, cube.y, cube.z).cast<float>();
    return voxel_m * (first + Eigen::Vector3f::Constant(0.5F * (edge_samples - 1.0F)));
}

float radius_of(float edge_samples, float voxel_m) {
    return 0.5F * std::sqrt(3.0F) * edge_samples * voxel_m;
}

}  // namespace

VisibleSpace::VisibleSpace(const TsdfView& view, const DepthRanges& ranges)
    : view_(view), ranges_(ranges) {
    const float half_x = std::max(view.cx_px, static_cast<float>(view.width_px) - view.cx_px);
    const float half_y = std::max(view.cy_px, static_cast<float>(view.height_px) - view.cy_px);
    slack_x_ = std::hypot(half_x, view.focal_px) / view.focal_px;
    slack_y_ = std::hypot(half_y, view.focal_px) / view.focal_px;
}

std::optional<BlockPlace> VisibleSpace::place_of(const Eigen::Vector3f& middle,
                                                 float radius_m) const {
    const Eigen::Vector3f p = view_.R_cam_world * middle + view_.t_cam_world;
    if (p.z() < -radius_m) return std::nullopt;
    const float z = std::max(0.0F, p.z());
    const float half_x = std::max(view_.cx_px, static_cast<float>(view_.width_px) - view_.cx_px);
    const float half_y = std::max(view_.cy_px, static_cast<float>(view_.height_px) - view_.cy_px);
    if (std::abs(p.x()) > z * half_x / view_.focal_px + slack_x_ * radius_m) return std::nullopt;
    if (std::abs(p.y()) > z * half_y / view_.focal_px + slack_y_ * radius_m) return std::nullopt;
    const DepthRange range = range_around(p, radius_m);
    if (p.z() - radius_m > range.farthest_m) return std::nullopt;
    return p.z() + radius_m < range.nearest_m ? BlockPlace::Before : BlockPlace::Near;
}

// Returns the range over the tiles that the ball may cover.
DepthRange VisibleSpace::range_around(const Eigen::Vector3f& p_cam, float radius_m) const {
    const float near = p_cam.z() - radius_m;
    int first_column = 0;
    int last_column = ranges_.num_columns(kLevel) - 1;
    int first_row = 0;
    int last_row = ranges_.num_rows(kLevel) - 1;
    if (near > radius_m) {
        const auto tile = [&](float x, float z, float c_px) {
            return static_cast<int>(std::floor((view_.focal_px * x / z + c_px + 0.5F) /
                                               static_cast<float>(DepthRanges::tile_px(kLevel))));
        };
        const float far = p_cam.z() + radius_m;
        const auto first = [&](float x, float c_px) {
            return tile(x - radius_m, x > radius_m ? far : near, c_px);
        };
        const auto last = [&](float x, float c_px) {
            return tile(x + radius_m, x < -radius_m ? far : near, c_px);
        };
        first_column = std::max(first_column, first(p_cam.x(), view_.cx_px));
        last_column = std::min(last_column, last(p_cam.x(), view_.cx_px));
        first_row = std::max(first_row, first(p_cam.y(), view_.cy_px));
        last_row = std::min(last_row, last(p_cam.y(), view_.cy_px));
    }
    return ranges_.over(kLevel, first_column, last_column, first_row, last_row);
}

void BlockRegions::add(const BlockCoordinate& block, std::uint32_t number) {
    const BlockCoordinate coordinate{block.x >> 3, block.y >> 3, block.z >> 3};
    const auto [entry, is_new] = index_.try_emplace(coordinate, regions_.size());
    if (is_new) regions_.push_back({coordinate, {}, {}});
    Region& region = regions_[entry->second];
    region.blocks.push_back(block);
    region.numbers.push_back(number);
}

Eigen::AlignedBox3f VisibleSpace::bounds() const {
    const auto to_world = [&](const Eigen::Vector3f& p_cam) {
        return Eigen::Vector3f(view_.R_cam_world.transpose() * (p_cam - view_.t_cam_world));
    };
    Eigen::AlignedBox3f box(to_world(Eigen::Vector3f::Zero()));
    constexpr int kMaxLevel = DepthRanges::kNumLevels - 1;
    const float far = ranges_
                          .over(kMaxLevel,
                                0,
                                ranges_.num_columns(kMaxLevel) - 1,
                                0,
                                ranges_.num_rows(kMaxLevel) - 1)
                          .farthest_m;
    for (const int u : {0, view_.width_px})
        for (const int v : {0, view_.height_px})
            box.extend(to_world({far * (static_cast<float>(u) - view_.cx_px) / view_.focal_px,
                                 far * (static_cast<float>(v) - view_.cy_px) / view_.focal_px,
                                 far}));
    return box;
}

std::vector<VisibleBlock> BlockRegions::find(const VisibleSpace& space, float voxel_m) const {
    const Eigen::AlignedBox3f box = space.bounds();
    const Eigen::Array3f in_regions(
        Eigen::Array3f::Constant(1.0F / (kRegionSize_samples * voxel_m)));
    // The first sample of a region lies on its border.
    const Eigen::Array3i first = (box.min().array() * in_regions - 0.1F).floor().cast<int>();
    const Eigen::Array3i last = (box.max().array() * in_regions + 0.1F).floor().cast<int>();
    const Eigen::Array3d extent = (last - first + 1).cast<double>();
    std::vector<VisibleBlock> found;
    if (extent.prod() > static_cast<double>(regions_.size())) {  // the view saw something far away
        for (const Region& region : regions_) find_in(region, space, voxel_m, found);
        return found;
    }
    for (int z = first.z(); z <= last.z(); ++z)
        for (int y = first.y(); y <= last.y(); ++y)
            for (int x = first.x(); x <= last.x(); ++x) {
                const auto entry = index_.find({x, y, z});
                if (entry != index_.end()) find_in(regions_[entry->second], space, voxel_m, found);
            }
    return found;
}

void BlockRegions::find_in(const Region& region,
                           const VisibleSpace& space,
                           float voxel_m,
                           std::vector<VisibleBlock>& found) {
    const Eigen::Vector3f middle = middle_of(region.coordinate, kRegionSize_samples, voxel_m);
    if (!space.place_of(middle, radius_of(kRegionSize_samples, voxel_m))) return;
    const float radius_m = radius_of(kBlockSize_samples, voxel_m);
    for (std::size_t i = 0; i < region.blocks.size(); ++i)
        if (const auto place =
                space.place_of(middle_of(region.blocks[i], kBlockSize_samples, voxel_m), radius_m))
            found.push_back({region.numbers[i], *place});
}

}  // namespace divemesh::fusion
