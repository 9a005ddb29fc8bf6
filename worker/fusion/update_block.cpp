#include "worker/fusion/update_block.hpp"

#include "worker/base/lanes.hpp"
#include "worker/fusion/packed_lanes.hpp"

namespace divemesh::worker {
namespace {

constexpr float kColorBand_voxels = 2.0F;
constexpr float kMinDepth_m = 0.1F;
// A view looks through what is so far before its surface. Readings that are too near are cut off at
// the truncation; if those as much too far counted, noise would push the surface back.
constexpr float kClear_sigmas = 2.0F * kTruncation_sigmas;
constexpr std::int32_t kFreeSteps = 2 * static_cast<std::int32_t>(kDistanceSteps);
constexpr std::int32_t kMaxSteps_int = 0x7fff;
constexpr float kMaxSteps = kMaxSteps_int;

// What a view says about the eight samples of a row.
struct Sighting {
    Masks updated;
    Masks seen_near;  // the surface, in range
    Masks colored;
    Floats share;  // of the new weight in the whole
    Masks color;   // red, green and blue from bit 16 down
};

DIVEMESH_INLINE_BODY Floats within_range(Floats steps) {
    return max(min(steps, broadcast(kMaxSteps)), broadcast(-kMaxSteps));
}

DIVEMESH_INLINE_BODY void update_color(const Sighting& sighting, int sample, TsdfBlock& block) {
    const Masks before = load_lanes<Masks>(block.color.data() + sample);
    const Floats share = max(sighting.share, broadcast(kMinColorShare));
    Masks after{};
    for (int channel = 0; channel < 3; ++channel) {
        const int shift = PackedTriple::kShift[channel];
        const Masks grey = (sighting.color >> (16 - 8 * channel)) & 0xff;
        const Floats seen =
            __builtin_convertvector(grey * PackedTriple::steps_per_grey(channel) + 1, Floats);
        const Masks mean = (before >> shift) & PackedTriple::largest(channel);
        const Floats mean_before = __builtin_convertvector(mean, Floats);
        const Floats moved = mean_before + share * (seen - mean_before);
        after |= to_integers((before == 0 ? seen : moved) + 0.5F) << shift;
    }
    store(block.color.data() + sample, sighting.colored ? after : before);
}

// The samples on the line x = 0..7 of the block, whose first is at p_cam and the next by step_cam
// on.
DIVEMESH_INLINE_BODY void update_row(const TsdfView& view,
                                     const DepthRanges& ranges,
                                     const Eigen::Vector3f& p_cam,
                                     const Eigen::Vector3f& step_cam,
                                     int sample,
                                     TsdfBlock& block) {
    const Floats along = __builtin_convertvector(kLaneNumbers, Floats);
    const Floats x = p_cam.x() + along * step_cam.x();
    const Floats y = p_cam.y() + along * step_cam.y();
    const Floats z = p_cam.z() + along * step_cam.z();
    const Floats scale = view.focal_px / z;
    const Floats u = scale * x + (view.cx_px + 0.5F);
    const Floats v = scale * y + (view.cy_px + 0.5F);
    const Masks in_view = (z >= kMinDepth_m) & (u >= 0.0F) & (v >= 0.0F) &
                          (u < static_cast<float>(view.width_px)) &
                          (v < static_cast<float>(view.height_px));
    if (!any(in_view)) return;
    const Masks pixel =
        to_integers(select(in_view, v)) * view.width_px + to_integers(select(in_view, u));
    Floats farthest{};
    for (int lane = 0; lane < kLanes; ++lane) farthest[lane] = ranges.farthest_m()[pixel[lane]];
    if (!any(in_view & (z <= farthest))) return;
    Floats fields[kLanes];
    for (int lane = 0; lane < kLanes; ++lane) fields[lane] = load(view.pixels[pixel[lane]].normal);
    transpose(fields);
    const Floats offset = fields[3];
    const Floats sigma_disparity = fields[4];
    const Floats depth = fields[5];
    const Floats certainty = fields[6];
    Sighting sighting;
    sighting.color = reinterpret_cast<Masks>(fields[7]);

    const Floats distance = offset - (fields[0] * x + fields[1] * y + fields[2] * z);
    const Floats sigma_scale = sigma_disparity * view.depth_sigma_scale;
    const Floats sigma = z * z * sigma_scale;
    const Floats truncation =
        max(broadcast(kTruncation_voxels * view.voxel_m), kTruncation_sigmas * sigma);
    const Masks known = in_view & (certainty > 0.0F) & (distance >= -truncation);
    if (!any(known)) return;
    const Masks packed_before =
        __builtin_convertvector(load_lanes<Shorts>(block.weight.data() + sample), Masks);
    const Floats weight_before = unpack_weights(packed_before);
    const Masks passed_through = distance > truncation;
    const Masks is_free = distance > max(truncation, kClear_sigmas * sigma);
    const Masks in_range =
        (depth <= view.max_depth_m) & (depth * depth * sigma_scale <= view.max_sigma_m);
    sighting.seen_near = known & ~passed_through & in_range;
    // What is in front of the surface, and what lies behind too far a surface, changes what is
    // there but makes nothing new.
    sighting.updated = sighting.seen_near | (known & (weight_before > 0.0F) & is_free);
    if (!any(sighting.updated)) return;

    // Behind the surface the weight falls, but not within the noise: the zero would move back.
    const Floats certain = max(broadcast(view.voxel_m), 2.0F * sigma);
    const Floats full = certainty / (sigma * sigma);
    const Floats weight =
        distance < -certain ? full * ((truncation + distance) / (truncation - certain)) : full;
    const Floats weight_after = weight_before + weight;
    sighting.share = weight / weight_after;
    const float steps = kDistanceSteps / view.voxel_m;
    const SignedShorts steps_before = load_lanes<SignedShorts>(block.distance.data() + sample);
    const Floats distance_before = __builtin_convertvector(steps_before, Floats);
    const Floats seen = within_range(steps * min(distance, truncation));
    const Floats distance_after = distance_before + sighting.share * (seen - distance_before);
    // Rounded where all are positive: whole() cuts toward zero.
    const Masks steps_after =
        to_integers(select(sighting.updated, distance_after) + (kMaxSteps + 0.5F)) - kMaxSteps_int;
    store(block.weight.data() + sample,
          __builtin_convertvector(sighting.updated ? pack_weights(weight_after) : packed_before,
                                  Shorts));
    store(block.distance.data() + sample,
          __builtin_convertvector(
              sighting.updated ? steps_after : __builtin_convertvector(steps_before, Masks),
              SignedShorts));

    if (any(sighting.seen_near)) {
        std::uint16_t* views = block.num_views.data() + sample;
        const Masks views_before = __builtin_convertvector(load_lanes<Shorts>(views), Masks);
        const Masks one_more = sighting.seen_near & (views_before < 0xffff) & 1;
        store(views, __builtin_convertvector(views_before + one_more, Shorts));
    }
    sighting.colored = sighting.updated & (abs(distance) <= kColorBand_voxels * view.voxel_m);
    if (any(sighting.colored)) update_color(sighting, sample, block);
}

// Whether some of eight samples is known and not well before every surface.
DIVEMESH_INLINE_BODY bool can_be_carved(const TsdfBlock& block, int sample) {
    const Masks weights =
        __builtin_convertvector(load_lanes<Shorts>(block.weight.data() + sample), Masks);
    const Masks steps =
        __builtin_convertvector(load_lanes<SignedShorts>(block.distance.data() + sample), Masks);
    return any((weights != 0) & (steps < kFreeSteps));
}

// Where the eight rows of samples of a layer lie: a bit for each that may be changed, and for each
// of these that lies before all surfaces.
struct RowPlaces {
    unsigned reached = 0xff;
    unsigned before = 0;
};

// Of pixels; of what is beside the picture the nearest tile in it.
DIVEMESH_INLINE_BODY Masks tile_of(Floats at_px, int tile_px, int num_tiles) {
    const Floats tile = (at_px + 0.5F) / static_cast<float>(tile_px);
    return to_integers(
        min(max(tile, broadcast(0.0F)), broadcast(static_cast<float>(num_tiles - 1))));
}

// A row is a line in the picture too, no longer than from its first to its last sample.
DIVEMESH_INLINE_BODY RowPlaces places_of_rows(const TsdfView& view,
                                              const DepthRanges& ranges,
                                              const Eigen::Vector3f& p_cam,
                                              const Eigen::Vector3f& step_x,
                                              const Eigen::Vector3f& step_y) {
    constexpr float kLast = kBlockEdge - 1;
    const Floats along = __builtin_convertvector(kLaneNumbers, Floats);
    const Floats z0 = p_cam.z() + along * step_y.z();
    const Floats z1 = z0 + kLast * step_x.z();
    const Floats nearest = min(z0, z1);
    if (any(nearest < kMinDepth_m)) return {};
    const Floats farthest = max(z0, z1);
    const Floats scale0 = view.focal_px / z0;
    const Floats scale1 = view.focal_px / z1;
    const Floats x0 = p_cam.x() + along * step_y.x();
    const Floats y0 = p_cam.y() + along * step_y.y();
    const Floats u0 = x0 * scale0, v0 = y0 * scale0;
    const Floats u1 = (x0 + kLast * step_x.x()) * scale1;
    const Floats v1 = (y0 + kLast * step_x.y()) * scale1;
    const Floats half_length = 0.5F * max(abs(u1 - u0), abs(v1 - v0));
    int level = 0;
    while (any(half_length > static_cast<float>(DepthRanges::tile_px(level))))
        if (++level == DepthRanges::kNumLevels) return {};
    const int tile_px = DepthRanges::tile_px(level);
    const Masks column = tile_of(0.5F * (u0 + u1) + view.cx_px, tile_px, ranges.num_columns(level));
    const Masks row = tile_of(0.5F * (v0 + v1) + view.cy_px, tile_px, ranges.num_rows(level));
    float nearest_m[kLanes], farthest_m[kLanes];
    std::int32_t columns[kLanes], rows[kLanes];
    store(nearest_m, nearest);
    store(farthest_m, farthest);
    store(columns, column);
    store(rows, row);
    RowPlaces places{0, 0};
    for (unsigned i = 0; i < kLanes; ++i) {
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
                  Instructions instructions) {
    compiled_for<update_samples>(instructions)(view, ranges, first, place, block);
}

}  // namespace divemesh::worker
