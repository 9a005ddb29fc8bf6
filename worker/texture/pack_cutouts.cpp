#include "worker/texture/pack_cutouts.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "schemas/error.hpp"
#include "worker/base/pack_rectangles.hpp"
#include "worker/types/texture.hpp"

namespace divemesh::texture {
namespace {

constexpr std::int64_t kBytesPerTexel = 3;

void check(const AtlasOptions& options) {
    constexpr int kMinSide_px = 64;
    constexpr int kMaxSide_px = 32768;
    if (options.max_side_px < kMinSide_px || options.max_side_px > kMaxSide_px)
        throw Error(ErrorCode::InvalidArgument,
                    "the largest side of an atlas is " + std::to_string(options.max_side_px) +
                        " px: give " + std::to_string(kMinSide_px) + " to " +
                        std::to_string(kMaxSide_px));
    if (options.max_texel_bytes < 0)
        throw Error(ErrorCode::InvalidArgument,
                    "the limit of all atlases is " + std::to_string(options.max_texel_bytes) +
                        " bytes: give 0 or more");
}

int scaled_px(int size_px, double scale) {
    return std::max(1, static_cast<int>(std::ceil(size_px * scale)));
}

PlacedCutout place_at_scale(const cv::Rect& pixels, double scale) {
    const int border_px = static_cast<int>(std::ceil(types::Texture::kBorder_px / scale));
    PlacedCutout place;
    place.pixels = {pixels.x - border_px,
                    pixels.y - border_px,
                    pixels.width + 2 * border_px,
                    pixels.height + 2 * border_px};
    place.texels = {
        0, 0, scaled_px(place.pixels.width, scale), scaled_px(place.pixels.height, scale)};
    return place;
}

// Returns the largest scale, at most 1, at which the cutout with its border fits a side.
double fitting_scale(const std::vector<Cutout>& cutouts, int max_side_px) {
    double scale = 1.0;
    for (const Cutout& cutout : cutouts) {
        const int side_px = std::max(cutout.pixels.width, cutout.pixels.height);
        // Scaling rounds border and side up, by less than 2 texels each.
        scale = std::min(
            scale, static_cast<double>(max_side_px - 2 * types::Texture::kBorder_px - 4) / side_px);
    }
    return scale;
}

AtlasPlan pack_at_scale(const std::vector<Cutout>& cutouts, int max_side_px, double scale) {
    AtlasPlan plan;
    plan.texels_per_pixel = scale;
    plan.places.reserve(cutouts.size());
    for (const Cutout& cutout : cutouts)
        plan.places.push_back(place_at_scale(cutout.pixels, scale));
    std::vector<cv::Size> sizes;
    for (const PlacedCutout& place : plan.places) sizes.push_back(place.texels.size());
    base::RectanglePacking packing = base::pack_rectangles(sizes, max_side_px);
    for (std::size_t i = 0; i < plan.places.size(); ++i) {
        plan.places[i].atlas = packing.sheet_of[i];
        plan.places[i].texels = {packing.corners[i], sizes[i]};
    }
    plan.sizes = std::move(packing.sheets);
    return plan;
}

std::int64_t num_bytes(const cv::Size& size) {
    return kBytesPerTexel * std::int64_t{size.width} * size.height;
}

std::int64_t num_bytes(const AtlasPlan& plan) {
    std::int64_t sum = 0;
    for (const cv::Size& size : plan.sizes) sum += num_bytes(size);
    return sum;
}

// Leaves out the last atlases, which hold the smallest cutouts.
void leave_out_beyond(std::int64_t max_bytes, AtlasPlan& plan) {
    while (num_bytes(plan) > max_bytes) plan.sizes.pop_back();
    for (PlacedCutout& place : plan.places)
        if (place.atlas >= static_cast<std::int32_t>(plan.sizes.size()))
            place.atlas = PlacedCutout::kNoRoom;
}

}  // namespace

Eigen::Vector2d PlacedCutout::texel(const Eigen::Vector2d& pixel) const {
    const Eigen::Vector2d from_corner_px(pixel.x() + 0.5 - pixels.x, pixel.y() + 0.5 - pixels.y);
    return {texels.x + from_corner_px.x() * texels.width / pixels.width - 0.5,
            texels.y + from_corner_px.y() * texels.height / pixels.height - 0.5};
}

AtlasPlan pack_cutouts(const std::vector<Cutout>& cutouts, const AtlasOptions& options) {
    constexpr double kMargin = 0.97;  // borders do not become smaller
    check(options);
    double scale = fitting_scale(cutouts, options.max_side_px);
    AtlasPlan plan = pack_at_scale(cutouts, options.max_side_px, scale);
    while (num_bytes(plan) > options.max_texel_bytes && scale > kMinTexelsPerPixel) {
        const double excess =
            static_cast<double>(num_bytes(plan)) /
            static_cast<double>(std::max<std::int64_t>(1, options.max_texel_bytes));
        scale = std::max(kMinTexelsPerPixel, kMargin * scale / std::sqrt(excess));
        plan = pack_at_scale(cutouts, options.max_side_px, scale);
    }
    leave_out_beyond(options.max_texel_bytes, plan);
    return plan;
}

}  // namespace divemesh::texture
