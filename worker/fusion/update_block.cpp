#include "worker/fusion/update_block.hpp"

#include "worker/base/lanes.hpp"
#include "worker/fusion/packed_lanes.hpp"

namespace divemesh::fusion {
namespace {

constexpr float kColorBand_voxels = 2.0F;
constexpr float kMinDepth_m = 0.1F;
// Distance in front of its surface beyond which a view carves. Readings that are too near are cut
// off at the truncation; if equally wrong far readings counted, noise would push the surface back.
constexpr float kClear_sigmas = 2.0F * kTruncation_sigmas;
constexpr std::int32_t kFreeSteps = 2 * static_cast<std::int32_t>(kDistanceSteps);
constexpr std::int32_t kUnsharedPixel = SurfacePixel::kUnshared;
constexpr std::int32_t kMaxSteps_int = 0x7fff;
constexpr float kMaxSteps = kMaxSteps_int;

// A view's observations of the eight samples of a row.
struct Sighting {
    base::Masks updated;
    base::Masks seen_near;  // near the surface, in range
    base::Masks colored;
    base::Floats share;  // of the new weight in the sum
    base::Masks color;   // as in SurfacePixel
};

DIVEMESH_INLINE_BODY base::Floats within_range(base::Floats steps) {
    return base::max(base::min(steps, base::broadcast(kMaxSteps)), base::broadcast(-kMaxSteps));
}

DIVEMESH_INLINE_BODY void update_color(const Sighting& sighting, int sample, TsdfBlock& block) {
    const base::Masks before = base::load_lanes<base::Masks>(block.color.data() + sample);
    const base::Floats share = base::max(sighting.share, base::broadcast(kMinColorShare));
    base::Masks after{};
    for (int channel = 0; channel < 3; ++channel) {
        const int shift = PackedTriple::kShift[channel];
        const base::Masks grey = (sighting.color >> (16 - 8 * channel)) & 0xff;
        const base::Floats seen =
            __builtin_convertvector(grey * PackedTriple::steps_per_grey(channel) + 1, base::Floats);
        const base::Masks mean = (before >> shift) & PackedTriple::largest(channel);
        const base::Floats mean_before = __builtin_convertvector(mean, base::Floats);
        const base::Floats moved = mean_before + share * (seen - mean_before);
        after |= base::to_integers((before == 0 ? seen : moved) + 0.5F) << shift;
    }
    base::store(block.color.data() + sample, sighting.colored ? after : before);
}

// Moves the mean distances toward the seen ones, in steps.
DIVEMESH_INLINE_BODY void update_distance(const Sighting& sighting,
                                          base::Floats seen_steps,
                                          int sample,
                                          TsdfBlock& block) {
    const base::SignedShorts steps_before =
        base::load_lanes<base::SignedShorts>(block.distance.data() + sample);
    const base::Floats before = __builtin_convertvector(steps_before, base::Floats);
    const base::Floats after = before + sighting.share * (within_range(seen_steps) - before);
    // Adds an offset to round positive numbers, as to_integers() truncates toward zero.
    const base::Masks steps_after =
        base::to_integers(base::select(sighting.updated, after) + (kMaxSteps + 0.5F)) -
        kMaxSteps_int;
    base::store(
        block.distance.data() + sample,
        __builtin_convertvector(
            sighting.updated ? steps_after : __builtin_convertvector(steps_before, base::Masks),
            base::SignedShorts));
}

DIVEMESH_INLINE_BODY void count_view(const Sighting& sighting, int sample, TsdfBlock& block) {
    std::uint16_t* views = block.views.data() + sample;
    const base::Masks before =
        __builtin_convertvector(base::load_lanes<base::Shorts>(views), base::Masks);
    const base::Masks can_count = (before & TsdfBlock::kMaxViews) < TsdfBlock::kMaxViews;
    const base::Masks one_more = sighting.seen_near & can_count & 1;
    const base::Masks unshared =
        sighting.seen_near & ((sighting.color & kUnsharedPixel) != 0) & TsdfBlock::kUnshared;
    base::store(views, __builtin_convertvector((before + one_more) | unshared, base::Shorts));
}

// Which of eight points of the camera frame lie in the image, and the numbers of their pixels; 0
// for the others.
struct Projection {
    base::Masks in_view;
    base::Masks pixel;
};

DIVEMESH_INLINE_BODY Projection project(const TsdfView& view,
                                        base::Floats x,
                                        base::Floats y,
                                        base::Floats z) {
    const base::Floats scale = view.focal_px / z;
    const base::Floats u = scale * x + (view.cx_px + 0.5F);
    const base::Floats v = scale * y + (view.cy_px + 0.5F);
    const base::Masks in_view = (z >= kMinDepth_m) & (u >= 0.0F) & (v >= 0.0F) &
                                (u < static_cast<float>(view.width_px)) &
                                (v < static_cast<float>(view.height_px));
    return {in_view,
            base::to_integers(base::select(in_view, v)) * view.width_px +
                base::to_integers(base::select(in_view, u))};
}

// Updates the samples on the line x = 0..7 of the block; the first is at p_cam, the next ones at
// intervals of step_cam.
DIVEMESH_INLINE_BODY void update_row(const TsdfView& view,
                                     const DepthRanges& ranges,
                                     const Eigen::Vector3f& p_cam,
                                     const Eigen::Vector3f& step_cam,
                                     int sample,
                                     TsdfBlock& block) {
    const base::Floats along = __builtin_convertvector(base::kLaneNumbers, base::Floats);
    const base::Floats x = p_cam.x() + along * step_cam.x();
    const base::Floats y = p_cam.y() + along * step_cam.y();
    const base::Floats z = p_cam.z() + along * step_cam.z();
    const auto [in_view, pixel] = project(view, x, y, z);
    if (!base::any(in_view)) return;
    base::Floats farthest{};
    for (int lane = 0; lane < base::kLanes; ++lane)
        farthest[lane] = ranges.farthest_m()[pixel[lane]];
    if (!base::any(in_view & (z <= farthest))) return;
    base::Floats fields[base::kLanes];
    for (int lane = 0; lane < base::kLanes; ++lane)
        fields[lane] = base::load(view.pixels[pixel[lane]].normal);
    base::transpose(fields);
    const base::Floats offset = fields[3];
    const base::Floats sigma_disparity = fields[4];
    const base::Floats depth = fields[5];
    const base::Floats certainty = fields[6];
    Sighting sighting;
    sighting.color = reinterpret_cast<base::Masks>(fields[7]);

    const base::Floats distance = offset - (fields[0] * x + fields[1] * y + fields[2] * z);
    const base::Floats sigma_scale = sigma_disparity * view.depth_sigma_scale;
    const base::Floats sigma = z * z * sigma_scale;
    const base::Floats truncation =
        base::max(base::broadcast(kTruncation_voxels * view.voxel_m), kTruncation_sigmas * sigma);
    const base::Masks known = in_view & (certainty > 0.0F) & (distance >= -truncation);
    if (!base::any(known)) return;
    const base::Masks packed_before = __builtin_convertvector(
        base::load_lanes<base::Shorts>(block.weight.data() + sample), base::Masks);
    const base::Floats weight_before = unpack_weights(packed_before);
    const base::Masks passed_through = distance > truncation;
    const base::Masks is_free = distance > base::max(truncation, kClear_sigmas * sigma);
    const base::Masks in_range =
        (depth <= view.max_depth_m) & (depth * depth * sigma_scale <= view.max_sigma_m);
    sighting.seen_near = known & ~passed_through & in_range;
    // Free space, including that in front of a surface beyond the range, changes known samples but
    // creates no new ones.
    sighting.updated = sighting.seen_near | (known & (weight_before > 0.0F) & is_free);
    if (!base::any(sighting.updated)) return;

    // The weight falls behind the surface, but not within the noise, where that would move the zero
    // back.
    const base::Floats certain = base::max(base::broadcast(view.voxel_m), 2.0F * sigma);
    const base::Floats full = certainty / (sigma * sigma);
    const base::Floats weight =
        distance < -certain ? full * ((truncation + distance) / (truncation - certain)) : full;
    const base::Floats weight_after = weight_before + weight;
    sighting.share = weight / weight_after;
    base::store(block.weight.data() + sample,
                __builtin_convertvector(
                    sighting.updated ? pack_weights(weight_after) : packed_before, base::Shorts));
    const float steps = kDistanceSteps / view.voxel_m;
    update_distance(sighting, steps * base::min(distance, truncation), sample, block);
    if (base::any(sighting.seen_near)) count_view(sighting, sample, block);
    sighting.colored = sighting.updated & (base::abs(distance) <= kColorBand_voxels * view.voxel_m);
    if (base::any(sighting.colored)) update_color(sighting, sample, block);
}

// Returns whether any of eight samples is known and not far in front of every surface.
DIVEMESH_INLINE_BODY bool can_be_carved(const TsdfBlock& block, int sample) {
    const base::Masks weights = __builtin_convertvector(
        base::load_lanes<base::Shorts>(block.weight.data() + sample), base::Masks);
    const base::Masks steps = __builtin_convertvector(
        base::load_lanes<base::SignedShorts>(block.distance.data() + sample), base::Masks);
    return base::any((weights != 0) & (steps < kFreeSteps));
}

// The places of the eight sample rows of a layer: a bit for each row that may change, and a bit for
// each of these in front of all surfaces.
struct RowPlaces {
    unsigned reached = 0xff;
    unsigned before = 0;
};

// Returns the tile of a pixel; for positions outside the image the nearest tile.
DIVEMESH_INLINE_BODY base::Masks tile_of(base::Floats at_px, int tile_px, int num_tiles) {
    const base::Floats tile = (at_px + 0.5F) / static_cast<float>(tile_px);
    return base::to_integers(base::min(base::max(tile, base::broadcast(0.0F)),
                                       base::broadcast(static_cast<float>(num_tiles - 1))));
}

// A row is a line in the image too, no longer than from its first to its last sample.
DIVEMESH_INLINE_BODY RowPlaces places_of_rows(const TsdfView& view,
                                              const DepthRanges& ranges,
                                              const Eigen::Vector3f& p_cam,
                                              const Eigen::Vector3f& step_x,
                                              const Eigen::Vector3f& step_y) {
    constexpr float kLast = kBlockEdge - 1;
    const base::Floats along = __builtin_convertvector(base::kLaneNumbers, base::Floats);
    const base::Floats z0 = p_cam.z() + along * step_y.z();
    const base::Floats z1 = z0 + kLast * step_x.z();
    const base::Floats nearest = base::min(z0, z1);
    if (base::any(nearest < kMinDepth_m)) return {};
    const base::Floats farthest = base::max(z0, z1);
    const base::Floats scale0 = view.focal_px / z0;
    const base::Floats scale1 = view.focal_px / z1;
    const base::Floats x0 = p_cam.x() + along * step_y.x();
    const base::Floats y0 = p_cam.y() + along * step_y.y();
    const base::Floats u0 = x0 * scale0, v0 = y0 * scale0;
    const base::Floats u1 = (x0 + kLast * step_x.x()) * scale1;
    const base::Floats v1 = (y0 + kLast * step_x.y()) * scale1;
    const base::Floats half_length = 0.5F * base::max(base::abs(u1 - u0), base::abs(v1 - v0));
    int level = 0;
    while (base::any(half_length > static_cast<float>(DepthRanges::tile_px(level))))
        if (++level == DepthRanges::kNumLevels) return {};
    const int tile_px = DepthRanges::tile_px(level);
    const base::Masks column =
        tile_of(0.5F * (u0 + u1) + view.cx_px, tile_px, ranges.num_columns(level));
    const base::Masks row = tile_of(0.5F * (v0 + v1) + view.cy_px, tile_px, ranges.num_rows(level));
    float nearest_m[base::kLanes], farthest_m[base::kLanes];
    std::int32_t columns[base::kLanes], rows[base::kLanes];
    base::store(nearest_m, nearest);
    base::store(farthest_m, farthest);
    base::store(columns, column);
    base::store(rows, row);
    RowPlaces places{0, 0};
    for (unsigned i = 0; i < base::kLanes; ++i) {
        const DepthRange& range = ranges.around(level, columns[i], rows[i]);
        if (nearest_m[i] <= range.farthest_m) places.reached |= 1U << i;
        if (farthest_m[i] < range.nearest_m) places.before |= 1U << i;
    }
    return places;
}

DIVEMESH_INLINE_BODY void update_samples(const TsdfView& view,
                                         const DepthRanges& ranges,
                                         const Eigen::Vector3i& first,
                                         BlockPlace place,
                                         TsdfBlock& block) {
    const Eigen::Matrix3f R = view.voxel_m * view.R_cam_world;
    const auto p_cam = [&](int y, int z) -> Eigen::Vector3f {
        const Eigen::Vector3f sample = (first + Eigen::Vector3i(0, y, z)).cast<float>();
        return {R(0, 0) * sample.x() + R(0, 1) * sample.y() + R(0, 2) * sample.z() +
                    view.t_cam_world.x(),
                R(1, 0) * sample.x() + R(1, 1) * sample.y() + R(1, 2) * sample.z() +
                    view.t_cam_world.y(),
                R(2, 0) * sample.x() + R(2, 1) * sample.y() + R(2, 2) * sample.z() +
                    view.t_cam_world.z()};
    };
    const Eigen::Vector3f step_x = R.col(0), step_y = R.col(1);
    for (int z = 0; z < kBlockEdge; ++z) {
        const RowPlaces places = places_of_rows(view, ranges, p_cam(0, z), step_x, step_y);
        for (int y = 0; y < kBlockEdge; ++y) {
            if (((places.reached >> y) & 1) == 0) continue;
            const int sample = sample_index(0, y, z);
            const bool before = place == BlockPlace::Before || ((places.before >> y) & 1) != 0;
            if (before && !can_be_carved(block, sample)) continue;
            update_row(view, ranges, p_cam(y, z), step_x, sample, block);
        }
    }
}

}  // namespace

void update_block(const TsdfView& view,
                  const DepthRanges& ranges,
                  const Eigen::Vector3i& first,
                  BlockPlace place,
                  TsdfBlock& block,
                  base::Instructions instructions) {
    base::compiled_for<update_samples>(instructions)(view, ranges, first, place, block);
}

}  // namespace divemesh::fusion
