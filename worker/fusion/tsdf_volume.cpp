#include "worker/fusion/tsdf_volume.hpp"

#include <algorithm>
#include <cmath>
#include <new>
#include <numeric>

#include "worker/base/parallel.hpp"
#include "worker/fusion/packed_values.hpp"
#include "worker/fusion/recent_blocks.hpp"
#include "worker/fusion/volume_file.hpp"
#include "worker/fusion/voxel_size.hpp"

namespace divemesh::fusion {
namespace {

constexpr int kAllocationStep_px = 2;
constexpr float kBeside_voxels = 1.5F;   // farthest sample of a cell that the surface crosses
constexpr float kMaxStep_voxels = 6.0F;  // max spacing of rays that hit every block
constexpr float kMaxFusedSigma_voxels = 10.0F;  // of a sample that is surface
// Share of a view's variance that all views of a place have in common: at silhouettes and at
// grazing angles every view is wrong in the same way, so that many vague ones do not make a certain
// one.
constexpr float kCommonVariance = 0.6F;
// Max distance of a confirmed point from the surface. Where as many views looked through the point
// as saw a surface, the zero is farther away.
constexpr float kConfirmed_voxels = 1.5F;
constexpr std::uint32_t kBlocksPerTrim = 4096;

float sigma_z(const TsdfView& view, float z, float sigma_disparity_px) {
    return z * z * (sigma_disparity_px * view.depth_sigma_scale);
}

// Returns the weight that a sample with the largest sigma that surface may have would have if its
// views had nothing in common.
float min_weight(double voxel_m) {
    const auto sigma_m = kMaxFusedSigma_voxels * static_cast<float>(voxel_m);
    return 1.0F / (sigma_m * sigma_m);
}

double tolerated_voxel_at(const VolumeSettings& settings, int level) {
    return tolerated_voxel_m(
        settings.rig, settings.median_voxel_m(), level - settings.levels->median_level());
}

float truncation_m(const TsdfView& view, float sigma) {
    return std::max(kTruncation_voxels * view.voxel_m, kTruncation_sigmas * sigma);
}

// Returns how far from a pixel's surface its ray allocates blocks, m: as far as samples count, and
// at grazing angles at least to those next to the surface. A block that only a later view allocates
// lacks the views before.
float reach_m(const TsdfView& view, const SurfacePixel& pixel, float sigma) {
    const float along_normal = pixel.offset_m / pixel.depth_m;  // per metre of the ray
    return std::max(truncation_m(view, sigma), kBeside_voxels * view.voxel_m / along_normal);
}

int rounded(float x) {
    const float shifted = x + 0.5F;
    const auto whole = static_cast<int>(shifted);
    return whole - static_cast<int>(shifted < static_cast<float>(whole));
}

// Prefetches the whole block: its samples are in four arrays, each too short for the processor's
// own prefetcher.
void prefetch(const TsdfBlock* block) {
    constexpr std::size_t kLine = 64;
    const auto* bytes = reinterpret_cast<const char*>(block);
    for (std::size_t i = 0; i < sizeof(TsdfBlock); i += kLine) __builtin_prefetch(bytes + i, 1, 2);
}

TsdfView view_of(const types::Keyframe& keyframe,
                 const DepthView& depth,
                 const VolumeSettings& settings,
                 int level) {
    const types::RectifiedRig& rig = depth.rig();
    const Eigen::Isometry3f T_cam_world = keyframe.T_world_cam.inverse().cast<float>();
    TsdfView view;
    view.pixels = depth.pixels();
    view.width_px = rig.width_px;
    view.height_px = rig.height_px;
    view.focal_px = static_cast<float>(rig.focal_px);
    view.cx_px = static_cast<float>(rig.cx_px);
    view.cy_px = static_cast<float>(rig.cy_px);
    view.R_cam_world = T_cam_world.linear();
    view.t_cam_world = T_cam_world.translation();
    view.voxel_m = static_cast<float>(std::ldexp(settings.voxel_m, level));
    view.max_depth_m = static_cast<float>(settings.max_depth_m);
    view.max_sigma_m = static_cast<float>(kMaxSigma_voxels * tolerated_voxel_at(settings, level));
    view.depth_sigma_scale = static_cast<float>(1.0 / (rig.focal_px * rig.baseline_m));
    return view;
}

// Returns the pixel spacing at which rays still hit every block of a surface at any visible
// distance.
int allocation_step_px(std::span<const TsdfView> views) {
    const auto hits_all = [](const TsdfView& view) {
        const float farthest_m = std::min(
            view.max_depth_m,
            std::sqrt(view.max_sigma_m /
                      (static_cast<float>(kMinDisparitySigma_px) * view.depth_sigma_scale)));
        const float apart_m = kAllocationStep_px * farthest_m / view.focal_px;
        return apart_m <= kMaxStep_voxels * view.voxel_m;
    };
    return std::all_of(views.begin(), views.end(), hits_all) ? kAllocationStep_px : 1;
}

}  // namespace

TsdfVolume::TsdfVolume(VolumeSettings settings)
    : Volume(std::move(settings)),
      regions_(static_cast<std::size_t>(settings_.levels->num_levels())),
      samples_(settings_.spill) {
    for (int level = 0; level < settings_.levels->num_levels(); ++level)
        min_weight_.push_back(min_weight(tolerated_voxel_at(settings_, level)));
}

void TsdfVolume::add(const types::Keyframe& keyframe, const DepthView& depth) {
    std::vector<TsdfView> views;
    views.reserve(regions_.size());
    for (int level = 0; level < settings_.levels->num_levels(); ++level)
        views.push_back(view_of(keyframe, depth, settings_, level));
    allocate(views, keyframe, depth);
    for (std::size_t level = 0; level < views.size(); ++level)
        if (!regions_[level].empty()) update(views[level], regions_[level]);
    samples_.trim();
    ++num_views_;
}

void TsdfVolume::update(const TsdfView& view, const BlockRegions& regions) {
    const DepthRanges ranges(view);
    const auto visible = regions.find(VisibleSpace(view, ranges), view.voxel_m);
    std::vector<TsdfBlock*> blocks;
    blocks.reserve(visible.size());
    for (const VisibleBlock& seen : visible) blocks.push_back(&block(seen.number));
    base::for_each_index(settings_.num_threads, visible.size(), [&](std::size_t i) {
        if (i + 1 < blocks.size()) prefetch(blocks[i + 1]);
        const VisibleBlock& seen = visible[i];
        update_block(view, ranges, first_sample(coordinates_[seen.number]), seen.place, *blocks[i]);
    });
}

// Allocates the blocks within the truncation distance of the pixels' surface.
void TsdfVolume::allocate(std::span<const TsdfView> views,
                          const types::Keyframe& keyframe,
                          const DepthView& depth) {
    const TsdfView& finest = views.front();
    const Eigen::Isometry3f T_voxel_cam(
        (Eigen::Scaling(1.0F / finest.voxel_m) * keyframe.T_world_cam.cast<float>()).matrix());
    const Eigen::Vector3f eye = T_voxel_cam.translation();
    // Finer levels were seen from near enough to be hit by other views' rays.
    const int step_px = allocation_step_px(views.subspan(settings_.levels->median_level()));
    RecentBlocks recent(*settings_.levels);
    const auto place_at = [&](const Eigen::Vector3f& p) -> RecentBlocks::Place& {
        return recent.at({rounded(p.x()), rounded(p.y()), rounded(p.z())});
    };
    for (int v = 0; v < finest.height_px; v += step_px)
        for (int u = 0; u < finest.width_px; u += step_px) {
            const SurfacePixel& pixel = depth.pixel(u, v);
            if (!count(views.back(), pixel)) continue;
            const Eigen::Vector3f ray =
                T_voxel_cam.linear() * depth.rig().point_cam(u, v, 1.0).cast<float>();
            const std::size_t level =
                views.size() == 1 ? 0 : place_at(eye + pixel.depth_m * ray).block.level;
            if (!makes_surface(views[level], pixel)) continue;
            const float sigma = sigma_z(finest, pixel.depth_m, pixel.sigma_disparity_px);
            // A coarser block beside this one needs its samples as far out as its own truncation.
            const float own_reach = reach_m(views[level], pixel, sigma);
            const float reach = reach_m(views[std::min(level + 1, views.size() - 1)], pixel, sigma);
            const float end = pixel.depth_m + reach;
            float step = 0.0F;
            for (float z = pixel.depth_m - reach; z < end + step; z += step) {
                const float at = std::min(z, end);
                RecentBlocks::Place& place = place_at(eye + at * ray);
                step = 0.5F * kBlockEdge * views[place.block.level].voxel_m;
                const bool is_too_far = place.block.level <= static_cast<int>(level) &&
                                        reach > own_reach &&
                                        std::abs(at - pixel.depth_m) > own_reach;
                if (place.is_allocated || is_too_far) continue;
                place.is_allocated = true;
                const auto [entry, is_new] =
                    index_.try_emplace(place.block, static_cast<std::uint32_t>(blocks_.size()));
                if (is_new) add_block(place.block);
            }
        }
}

bool TsdfVolume::count(const TsdfView& coarsest, const SurfacePixel& pixel) {
    if (pixel.weight <= 0.0F) return false;
    ++fused_pixels_.num;
    if (makes_surface(coarsest, pixel)) return true;
    ++(pixel.depth_m > coarsest.max_depth_m ? fused_pixels_.num_too_far
                                            : fused_pixels_.num_too_vague);
    return false;
}

void TsdfVolume::add_block(const BlockCoordinate& block) {
    regions_[block.level].add(block, static_cast<std::uint32_t>(blocks_.size()));
    coordinates_.push_back(block);
    blocks_.push_back(samples_.allocate(sizeof(TsdfBlock)));
    new (samples_.write(blocks_.back())) TsdfBlock;
}

TsdfBlock& TsdfVolume::block(std::uint32_t number) {
    return *std::launder(reinterpret_cast<TsdfBlock*>(samples_.write(blocks_[number])));
}
const TsdfBlock& TsdfVolume::block(std::uint32_t number) const {
    return *std::launder(reinterpret_cast<const TsdfBlock*>(samples_.read(blocks_[number])));
}

bool TsdfVolume::is_confirmed(const TsdfBlock& samples, int i, int level) const {
    return (samples.num_views(i) >= std::min(kMinViews, num_views_) || samples.is_unshared(i)) &&
           unpack_weight(samples.weight[i]) >=
               min_weight_[level] *
                   (1.0F + kCommonVariance * static_cast<float>(samples.num_views(i)));
}

void TsdfVolume::confirm(std::span<const Eigen::Vector3d> p_world, std::uint8_t* out) const {
    constexpr float kMaxDistanceSteps = kConfirmed_voxels * kDistanceSteps;
    BlockCoordinate at{INT32_MAX, 0, 0};  // the last point's, of level 0
    const TsdfBlock* samples = nullptr;
    int level = 0;
    for (const Eigen::Vector3d& p : p_world) {
        const Eigen::Vector3i sample = (p / settings_.voxel_m).array().round().matrix().cast<int>();
        if (const BlockCoordinate here = block_of(sample); here != at) {
            at = here;
            const auto entry = index_.find(settings_.levels->block_at(sample));
            samples = entry == index_.end() ? nullptr : &block(entry->second);
            level = entry == index_.end() ? 0 : entry->first.level;
        }
        const int i = index_in_block(sample.unaryExpr([&](int x) { return x >> level; }));
        *out++ = samples != nullptr && is_confirmed(*samples, i, level) &&
                 std::abs(static_cast<float>(samples->distance[i])) < kMaxDistanceSteps;
    }
}

// The TSDF as the meshers see it: only samples that enough views confirm.
class TsdfField : public SignedDistanceField {
public:
    explicit TsdfField(const TsdfVolume& volume) : volume_(volume) {
        order_.resize(volume.blocks_.size());
        std::iota(order_.begin(), order_.end(), 0U);
        std::sort(order_.begin(), order_.end(), [&](std::uint32_t a, std::uint32_t b) {
            const BlockCoordinate& first = volume.coordinates_[a];
            const BlockCoordinate& second = volume.coordinates_[b];
            return std::pair(first.level, first) < std::pair(second.level, second);
        });
        for (const std::uint32_t i : order_) blocks_.push_back(volume.coordinates_[i]);
    }

    double voxel_m() const override { return volume_.voxel_m(); }
    const std::vector<BlockCoordinate>& blocks() const override { return blocks_; }
    void read_distances(std::size_t block, float* distances_m) const override {
        const TsdfBlock& samples = volume_.block(order_[block]);
        const int level = blocks_[block].level;
        for (int i = 0; i < kBlockSamples; ++i) distances_m[i] = distance_of(samples, i, level);
    }
    float distance_m(std::size_t block, int sample) const override {
        return distance_of(volume_.block(order_[block]), sample, blocks_[block].level);
    }
    SampleAttributes attributes(std::size_t block, int sample) const override {
        const TsdfBlock& samples = volume_.block(order_[block]);
        const std::uint32_t color = samples.color[sample];
        const float weight = unpack_weight(samples.weight[sample]);
        SampleAttributes attributes;
        attributes.has_color = color != 0;
        for (int channel = 0; channel < 3 && color != 0; ++channel)
            attributes.color[channel] = unpack_grey(color, channel);
        attributes.sigma_m = weight > 0.0F ? 1.0F / std::sqrt(weight) : 0.0F;
        attributes.num_observations = samples.num_views(sample);
        return attributes;
    }
    void release_memory() const override { volume_.trim(); }

private:
    float distance_of(const TsdfBlock& samples, int i, int level) const {
        if (!volume_.is_confirmed(samples, i, level)) return kUnknownDistance;
        const auto voxel_m = static_cast<float>(std::ldexp(volume_.voxel_m(), level));
        return voxel_m / kDistanceSteps * static_cast<float>(samples.distance[i]);
    }

    const TsdfVolume& volume_;
    std::vector<std::uint32_t> order_;
    std::vector<BlockCoordinate> blocks_;
};

std::unique_ptr<SignedDistanceField> TsdfVolume::field(int) const {
    return std::make_unique<TsdfField>(*this);
}

std::int64_t TsdfVolume::memory_bytes() const {
    const std::size_t each =
        4 * sizeof(BlockCoordinate) + sizeof(SpillStore::Handle) + 4 * sizeof(void*);
    return samples_.memory_bytes() + static_cast<std::int64_t>(blocks_.size() * each);
}

void TsdfVolume::save(const std::filesystem::path& path) const {
    base::BinaryWriter file(path);
    put_volume_header(file, kTsdfMagic, settings_);
    settings_.levels->save(file);
    file.put(num_views_);
    file.put(static_cast<std::uint64_t>(blocks_.size()));
    for (std::uint32_t i = 0; i < blocks_.size(); ++i) {
        file.put(coordinates_[i]);
        file.put(block(i));
        if (i % kBlocksPerTrim == 0) samples_.trim();
    }
    file.commit();
}

std::unique_ptr<TsdfVolume> TsdfVolume::load(base::BinaryReader& file, SpillSettings spill) {
    VolumeSettings settings = get_volume_settings(file);
    settings.levels = std::make_shared<LevelPlan>(LevelPlan::load(file));
    settings.spill = std::move(spill);
    auto volume = std::make_unique<TsdfVolume>(settings);
    volume->num_views_ = file.get<std::uint32_t>();
    const auto num_blocks = file.get<std::uint64_t>();
    for (std::uint32_t i = 0; i < num_blocks && file.ok(); ++i) {
        const auto coordinate = file.get<BlockCoordinate>();
        if (coordinate.level < 0 || coordinate.level >= volume->settings_.levels->num_levels())
            return nullptr;
        volume->index_.emplace(coordinate, i);
        volume->add_block(coordinate);
        volume->block(i) = file.get<TsdfBlock>();
        if (i % kBlocksPerTrim == 0) volume->samples_.trim();
    }
    return volume;
}

}  // namespace divemesh::fusion
