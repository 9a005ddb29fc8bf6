#include "worker/volume/tsdf_volume.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "worker/parallel.hpp"
#include "worker/volume/marching_cubes.hpp"
#include "worker/volume/volume_file.hpp"

namespace divemesh::worker {
namespace {

constexpr float kTruncation_voxels = 3.0F;
constexpr float kTruncation_sigmas = 3.0F;
constexpr float kColorBand_voxels = 2.0F;
constexpr float kNearest_m = 0.1F;
constexpr int kAllocationStep_px = 3;
constexpr std::uint32_t kLeastViews = 3;  // of a sample before it may be surface

}  // namespace

// One keyframe on its way into the volume.
struct TsdfVolume::View {
    const RectifiedRig& rig;
    const cv::Mat& image;  // CV_8UC3 BGR
    DepthView depth;
    Eigen::Isometry3f T_cam_world;
    Eigen::Isometry3f T_world_cam;
    float voxel_m;
    float max_depth_m;

    float sigma_z(float z, float sigma_disparity_px) const {
        return z * z * sigma_disparity_px / static_cast<float>(rig.focal_px * rig.baseline_m);
    }
    float truncation(float sigma) const {
        return std::max(kTruncation_voxels * voxel_m, kTruncation_sigmas * sigma);
    }
};

TsdfVolume::TsdfVolume(const VolumeSettings& settings) : settings_(settings) {}

void TsdfVolume::integrate(const Keyframe& keyframe, const KeyframeImages& images) {
    const View view{settings_.rig,
                    images.left_color,
                    DepthView(settings_.rig, images.depth),
                    keyframe.T_world_cam.inverse().cast<float>(),
                    keyframe.T_world_cam.cast<float>(),
                    static_cast<float>(settings_.voxel_m),
                    static_cast<float>(settings_.max_depth_m)};
    allocate(view);
    const auto visible = visible_blocks(view);
    for_each_index(settings_.num_threads, visible.size(), [&](std::size_t i) {
        update_block(view, visible[i]);
    });
    ++num_views_;
}

void TsdfVolume::allocate(const View& view) {
    for (int v = 0; v < view.depth.height_px(); v += kAllocationStep_px)
        for (int u = 0; u < view.depth.width_px(); u += kAllocationStep_px)
            allocate_along(view, u, v);
}

// The blocks within the truncation distance of what a pixel saw.
void TsdfVolume::allocate_along(const View& view, int u_px, int v_px) {
    const SurfacePixel& pixel = view.depth.pixel(u_px, v_px);
    if (pixel.weight <= 0.0F || pixel.depth_m > view.max_depth_m) return;
    const Eigen::Vector3f ray = settings_.rig.point_cam(u_px, v_px, 1.0).cast<float>();
    const float sigma = view.sigma_z(pixel.depth_m, pixel.sigma_disparity_px);
    const float truncation = view.truncation(sigma);
    const float step = 0.5F * kBlockEdge * view.voxel_m;
    BlockCoordinate last{INT32_MAX, 0, 0};
    for (float z = pixel.depth_m - truncation; z < pixel.depth_m + truncation + step; z += step) {
        const float at = std::min(z, pixel.depth_m + truncation);
        const Eigen::Vector3f p_world = view.T_world_cam * Eigen::Vector3f(at * ray);
        const Eigen::Vector3i sample =
            (p_world / view.voxel_m).array().round().matrix().cast<int>();
        const BlockCoordinate block = block_of(sample);
        if (block == last) continue;
        last = block;
        const auto [entry, is_new] =
            index_.try_emplace(block, static_cast<std::uint32_t>(blocks_.size()));
        if (!is_new) continue;
        coordinates_.push_back(block);
        blocks_.push_back(std::make_unique<TsdfBlock>());
    }
}

std::vector<std::size_t> TsdfVolume::visible_blocks(const View& view) const {
    const float edge = kBlockEdge * view.voxel_m;
    const float radius = 0.5F * std::sqrt(3.0F) * edge;
    const auto& rig = settings_.rig;
    const auto half_x = static_cast<float>(std::max(rig.cx_px, rig.width_px - rig.cx_px));
    const auto half_y = static_cast<float>(std::max(rig.cy_px, rig.height_px - rig.cy_px));
    const auto focal = static_cast<float>(rig.focal_px);
    const float slack_x = radius * std::hypot(half_x, focal) / focal;
    const float slack_y = radius * std::hypot(half_y, focal) / focal;
    std::vector<std::size_t> visible;
    for (std::size_t i = 0; i < coordinates_.size(); ++i) {
        const Eigen::Vector3f middle = view.voxel_m * (first_sample(coordinates_[i]).cast<float>() +
                                                       Eigen::Vector3f::Constant(3.5F));
        const Eigen::Vector3f p = view.T_cam_world * middle;
        if (p.z() < -radius || p.z() > view.max_depth_m + 2.0F * edge) continue;
        const float z = std::max(0.0F, p.z());
        if (std::abs(p.x()) > z * half_x / focal + slack_x) continue;
        if (std::abs(p.y()) > z * half_y / focal + slack_y) continue;
        visible.push_back(i);
    }
    return visible;
}

void TsdfVolume::update_block(const View& view, std::size_t block) {
    TsdfBlock& samples = *blocks_[block];
    const Eigen::Vector3i first = first_sample(coordinates_[block]);
    const auto focal = static_cast<float>(settings_.rig.focal_px);
    const auto cx = static_cast<float>(settings_.rig.cx_px);
    const auto cy = static_cast<float>(settings_.rig.cy_px);
    for (int i = 0; i < kBlockSamples; ++i) {
        const Eigen::Vector3f p_world =
            view.voxel_m * (first + Eigen::Vector3i(i & 7, (i >> 3) & 7, i >> 6)).cast<float>();
        const Eigen::Vector3f p = view.T_cam_world * p_world;
        if (p.z() < kNearest_m) continue;
        const float u = focal * p.x() / p.z() + cx + 0.5F, v = focal * p.y() / p.z() + cy + 0.5F;
        if (u < 0.0F || v < 0.0F) continue;
        const int column = static_cast<int>(u), row = static_cast<int>(v);
        if (column >= view.depth.width_px() || row >= view.depth.height_px()) continue;
        const SurfacePixel& pixel = view.depth.pixel(column, row);
        if (pixel.weight <= 0.0F) continue;

        const float distance = pixel.offset_m - pixel.normal.dot(p);
        const float sigma = view.sigma_z(p.z(), pixel.sigma_disparity_px);
        const float truncation = view.truncation(sigma);
        if (distance < -truncation) continue;
        float weight = pixel.weight / (sigma * sigma);
        if (distance > truncation || pixel.depth_m > view.max_depth_m) {
            if (samples.weight[i] <= 0.0F || distance < truncation) continue;
        } else if (samples.num_views[i] < UINT16_MAX) {
            ++samples.num_views[i];
        }
        // Behind the surface the weight falls, but not within the noise: the zero would move back.
        const float certain = std::max(view.voxel_m, 2.0F * sigma);
        if (distance < -certain) weight *= (truncation + distance) / (truncation - certain);
        const float whole = samples.weight[i] + weight;
        const float share = weight / whole;
        samples.distance_m[i] += share * (std::min(distance, truncation) - samples.distance_m[i]);
        samples.weight[i] = whole;
        if (std::abs(distance) > kColorBand_voxels * view.voxel_m) continue;
        const auto& bgr = view.image.at<cv::Vec3b>(row, column);
        for (int channel = 0; channel < 3; ++channel) {
            std::uint16_t& mean = samples.color[i][channel];
            const float seen = 256.0F * static_cast<float>(bgr[2 - channel]) + 1.0F;
            const float before = mean == 0 ? seen : static_cast<float>(mean);
            mean = static_cast<std::uint16_t>(std::lround(before + share * (seen - before)));
        }
    }
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
        const auto& color = samples.color[sample];
        attributes.has_color = (color[0] | color[1] | color[2]) != 0;
        for (int channel = 0; channel < 3; ++channel)
            attributes.color[channel] = static_cast<std::uint8_t>(color[channel] >> 8);
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
        volume->coordinates_.push_back(coordinate);
        volume->blocks_.push_back(std::make_unique<TsdfBlock>(file.get<TsdfBlock>()));
    }
    return volume;
}

}  // namespace divemesh::worker
