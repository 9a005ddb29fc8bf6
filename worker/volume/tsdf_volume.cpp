#include "worker/volume/tsdf_volume.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "worker/parallel.hpp"
#include "worker/volume/marching_cubes.hpp"
#include "worker/volume/volume_file.hpp"

namespace divemesh::worker {
namespace {

constexpr int kAllocationStep_px = 3;
constexpr float kLargestSigma_voxels = 4.0F;  // of a depth that may make surface
constexpr std::uint32_t kLeastViews = 3;      // of a sample before it may be surface

float sigma_z(const TsdfView& view, float z, float sigma_disparity_px) {
    return z * z * (sigma_disparity_px * view.depth_sigma_scale);
}

float truncation_m(const TsdfView& view, float sigma) {
    return std::max(kTruncation_voxels * view.voxel_m, kTruncation_sigmas * sigma);
}

}  // namespace

TsdfVolume::TsdfVolume(const VolumeSettings& settings) : settings_(settings) {}

void TsdfVolume::integrate(const Keyframe& keyframe, const KeyframeImages& images) {
    const RectifiedRig& rig = settings_.rig;
    const DepthView depth(rig, images, settings_.num_threads);
    const Eigen::Isometry3f T_cam_world = keyframe.T_world_cam.inverse().cast<float>();
    TsdfView view;
    view.pixels = depth.pixels();
    view.width_px = depth.width_px();
    view.height_px = depth.height_px();
    view.focal_px = static_cast<float>(rig.focal_px);
    view.cx_px = static_cast<float>(rig.cx_px);
    view.cy_px = static_cast<float>(rig.cy_px);
    view.R_cam_world = T_cam_world.linear();
    view.t_cam_world = T_cam_world.translation();
    view.voxel_m = static_cast<float>(settings_.voxel_m);
    view.max_depth_m = static_cast<float>(settings_.max_depth_m);
    view.max_sigma_m = kLargestSigma_voxels * view.voxel_m;
    view.depth_sigma_scale = static_cast<float>(1.0 / (rig.focal_px * rig.baseline_m));
    allocate(view, keyframe.T_world_cam);
    const auto visible = regions_.find(VisibleSpace(view), view.voxel_m);
    for_each_index(settings_.num_threads, visible.size(), [&](std::size_t i) {
        const std::uint32_t block = visible[i];
        update_block(view, first_sample(coordinates_[block]), *blocks_[block]);
    });
    ++num_views_;
}

// The blocks within the truncation distance of what the pixels saw.
void TsdfVolume::allocate(const TsdfView& view, const Eigen::Isometry3d& T_world_cam) {
    const Eigen::Isometry3f T_voxel_cam(
        (Eigen::Scaling(1.0F / view.voxel_m) * T_world_cam.cast<float>()).matrix());
    const float step = 0.5F * kBlockEdge * view.voxel_m;
    BlockCoordinate last{INT32_MAX, 0, 0};
    for (int v = 0; v < view.height_px; v += kAllocationStep_px)
        for (int u = 0; u < view.width_px; u += kAllocationStep_px) {
            const SurfacePixel& pixel = view.pixels[v * view.width_px + u];
            if (!makes_surface(view, pixel)) continue;
            const Eigen::Vector3f ray = settings_.rig.point_cam(u, v, 1.0).cast<float>();
            const float truncation =
                truncation_m(view, sigma_z(view, pixel.depth_m, pixel.sigma_disparity_px));
            const float end = pixel.depth_m + truncation;
            for (float z = pixel.depth_m - truncation; z < end + step; z += step) {
                const Eigen::Vector3f p = T_voxel_cam * Eigen::Vector3f(std::min(z, end) * ray);
                const BlockCoordinate block = block_of(p.array().round().matrix().cast<int>());
                if (block == last) continue;
                last = block;
                const auto [entry, is_new] =
                    index_.try_emplace(block, static_cast<std::uint32_t>(blocks_.size()));
                if (is_new) add_block(block);
            }
        }
}

void TsdfVolume::add_block(const BlockCoordinate& block) {
    regions_.add(block, static_cast<std::uint32_t>(blocks_.size()));
    coordinates_.push_back(block);
    blocks_.push_back(std::make_unique<TsdfBlock>());
}

// What the meshers see: samples that enough views agree on.
class TsdfField : public SignedField {
public:
    explicit TsdfField(const TsdfVolume& volume)
        : volume_(volume), least_views_(std::min(kLeastViews, volume.num_views_)) {
        order_.resize(volume.blocks_.size());
        std::iota(order_.begin(), order_.end(), std::size_t{0});
        std::sort(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) {
            return volume.coordinates_[a] < volume.coordinates_[b];
        });
        for (const std::size_t i : order_) blocks_.push_back(volume.coordinates_[i]);
    }

    double voxel_m() const override { return volume_.voxel_m(); }
    const std::vector<BlockCoordinate>& blocks() const override { return blocks_; }
    void read_distances(std::size_t block, float* distances_m) const override {
        for (int i = 0; i < kBlockSamples; ++i) distances_m[i] = distance_m(block, i);
    }
    float distance_m(std::size_t block, int sample) const override {
        const TsdfBlock& samples = *volume_.blocks_[order_[block]];
        return samples.num_views[sample] >= least_views_ && samples.weight[sample] > 0.0F
                   ? samples.distance_m[sample]
                   : kUnknownDistance;
    }
    SampleAttributes attributes(std::size_t block, int sample) const override {
        const TsdfBlock& samples = *volume_.blocks_[order_[block]];
        SampleAttributes attributes;
        for (int channel = 0; channel < 3; ++channel) {
            const std::uint16_t mean = samples.color[channel][sample];
            attributes.has_color = attributes.has_color || mean != 0;
            attributes.color[channel] = static_cast<std::uint8_t>(mean >> 8);
        }
        attributes.sigma_m =
            samples.weight[sample] > 0.0F ? 1.0F / std::sqrt(samples.weight[sample]) : 0.0F;
        attributes.num_observations = samples.num_views[sample];
        return attributes;
    }

private:
    const TsdfVolume& volume_;
    std::uint32_t least_views_;
    std::vector<std::size_t> order_;
    std::vector<BlockCoordinate> blocks_;
};

std::unique_ptr<SignedField> TsdfVolume::field(int) const {
    return std::make_unique<TsdfField>(*this);
}

PointCloud TsdfVolume::cloud() const {
    Mesh surface = marching_cubes(TsdfField(*this), {.num_threads = settings_.num_threads});
    return {std::move(surface.vertices), std::move(surface.colors)};
}

std::int64_t TsdfVolume::memory_bytes() const {
    const std::size_t each = sizeof(TsdfBlock) + 2 * sizeof(BlockCoordinate) +
                             sizeof(std::unique_ptr<TsdfBlock>) + 4 * sizeof(void*);
    return static_cast<std::int64_t>(blocks_.size() * each);
}

void TsdfVolume::save(const std::filesystem::path& path) const {
    BinaryWriter file(path);
    put_volume_header(file, kTsdfMagic, settings_);
    file.put(num_views_);
    file.put(static_cast<std::uint64_t>(blocks_.size()));
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
        file.put(coordinates_[i]);
        file.put(*blocks_[i]);
    }
    file.commit();
}

std::unique_ptr<TsdfVolume> TsdfVolume::load(BinaryReader& file) {
    auto volume = std::make_unique<TsdfVolume>(get_volume_settings(file));
    volume->num_views_ = file.get<std::uint32_t>();
    const auto num_blocks = file.get<std::uint64_t>();
    for (std::uint64_t i = 0; i < num_blocks && file.ok(); ++i) {
        const auto coordinate = file.get<BlockCoordinate>();
        volume->index_.emplace(coordinate, static_cast<std::uint32_t>(i));
        volume->add_block(coordinate);
        *volume->blocks_.back() = file.get<TsdfBlock>();
    }
    return volume;
}

}  // namespace divemesh::worker
