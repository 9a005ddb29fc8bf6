#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core/types.hpp>
#include <vector>

#include "worker/texture/cut_charts.hpp"

namespace divemesh::texture {

// The limits of the atlases of a mesh.
struct AtlasOptions {
    int max_side_px = 8192;                                // of an atlas; 64 to 32768
    std::int64_t max_texel_bytes = std::int64_t{1} << 29;  // of all atlases; beyond it texels
                                                           // become larger
};

// Where a cutout is in the atlases.
struct PlacedCutout {
    static constexpr std::int32_t kNoRoom = -1;

    std::int32_t atlas = kNoRoom;
    cv::Rect pixels;  // of the image, with the border; may reach beyond the image
    cv::Rect texels;  // of the atlas

    // Returns where a pixel of the image lies in the atlas (both: centres at integers).
    Eigen::Vector2d texel(const Eigen::Vector2d& pixel) const;
};

// The atlases of a mesh.
struct AtlasPlan {
    std::vector<cv::Size> sizes;
    std::vector<PlacedCutout> places;  // one per cutout
    double texels_per_pixel = 1.0;
};

inline constexpr double kMinTexelsPerPixel = 1.0 / 16.0;

// Packs the cutouts into atlases. All become smaller by the same factor if they exceed the limits;
// what even at kMinTexelsPerPixel has no room is left out. Throws Error{InvalidArgument} on
// wrong limits.
AtlasPlan pack_cutouts(const std::vector<Cutout>& cutouts, const AtlasOptions& options);

}  // namespace divemesh::texture
