#include "worker/volume/depth_view.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "worker/lanes.hpp"
#include "worker/parallel.hpp"

namespace divemesh::worker {
namespace {

constexpr float kLargestSlope = 1.0F;  // of disparity per pixel; steeper is a jump
constexpr int kReach_px = 4;           // of the gradient
constexpr float kDeadRim_px = 2.0F;
constexpr float kFullWeight_px = 5.0F;  // from a jump or the unknown
constexpr float kLeastCosine = 0.15F;   // of the angle of incidence

DIVEMESH_INLINE_BODY void mark_inside_body(const float* __restrict above,
                                           const float* __restrict row,
                                           const float* __restrict below,
                                           int width,
                                           std::uint8_t* __restrict inside) {
    for (int x = 1; x + 1 < width; ++x) {
        const float d = row[x];
        const int near = static_cast<int>(std::abs(row[x - 1] - d) < kLargestSlope) &
                         static_cast<int>(std::abs(row[x + 1] - d) < kLargestSlope) &
                         static_cast<int>(std::abs(above[x] - d) < kLargestSlope) &
                         static_cast<int>(std::abs(below[x] - d) < kLargestSlope) &
                         static_cast<int>(d > 0.0F);
        inside[x] = static_cast<std::uint8_t>(near);
    }
}

// Slope of the disparity along one axis: differences of pixels on opposite sides, of those pairs
// that are on one plane with the centre.
struct SlopeFit {
    Floats numerator;
    Floats denominator;
};

DIVEMESH_INLINE_BODY void add_pair(
    SlopeFit& fit, Floats center, Floats ahead, Floats behind, int reach_px) {
    const auto reach = static_cast<float>(reach_px);
    const Masks on_plane = (ahead > 0.0F) & (behind > 0.0F) &
                           (size_of(ahead - behind) <= 2.0F * kLargestSlope * reach) &
                           (size_of(ahead + behind - 2.0F * center) <= 1.0F);
    fit.numerator += where(on_plane, 2.0F * reach * (ahead - behind));
    fit.denominator += where(on_plane, splat(4.0F * reach * reach));
}

// One row of a keyframe's depth, and the rows around it.
struct DepthRow {
    const float* disparity;  // of the row, and `stride` floats on the next
    std::ptrdiff_t stride;
    const float* sigma;
    const float* rim;           // distance from the nearest unknown pixel or jump, px
    const std::uint8_t* image;  // BGR
    int width;
    float v;  // of the row, from the principal point
};

struct Optics {
    float focal;
    float focal_baseline;
    float cx;
};

// Red, green and blue from bit 16 down, of eight pixels. Reads one byte more, so not for the last.
DIVEMESH_INLINE_BODY Masks colors(const std::uint8_t* bgr) {
    Masks packed;
    for (int i = 0; i < kLanes; ++i) {
        std::uint32_t four;
        std::memcpy(&four, bgr + 3 * i, sizeof four);
        packed[i] = static_cast<std::int32_t>(four & 0xffffff);
    }
    return packed;
}

// The tangent planes of a row: n ~ (f d_u, f d_v, d - (u - cx) d_u - (v - cy) d_v), scaled so that
// n . p = f b on the plane.
DIVEMESH_INLINE_BODY void fit_planes_body(const DepthRow& row,
                                          const Optics& optics,
                                          SurfacePixel* pixels) {
    for (int start = kReach_px; start < row.width - kReach_px; start += kLanes) {
        // The last eight overlap the ones before.
        const int u = std::min(start, row.width - kReach_px - kLanes);
        const Floats inside = load(row.rim + u);
        Masks good = inside > kDeadRim_px;
        if (!any(good)) continue;
        const float* at = row.disparity + u;
        const Floats d = load(at);
        SlopeFit along_u{};
        SlopeFit along_v{};
        for (int reach = 2; reach <= kReach_px; reach += 2)
            for (int side = -kReach_px; side <= kReach_px; side += kReach_px) {
                const std::ptrdiff_t rows_u = side * row.stride;
                const std::ptrdiff_t rows_v = reach * row.stride;
                add_pair(along_u, d, load(at + rows_u + reach), load(at - rows_u - reach), reach);
                add_pair(along_v, d, load(at + rows_v + side), load(at - rows_v - side), reach);
            }
        good &= (along_u.denominator > 0.0F) & (along_v.denominator > 0.0F);
        const Floats slope_u = along_u.numerator / largest_of(along_u.denominator, splat(1.0F));
        const Floats slope_v = along_v.numerator / largest_of(along_v.denominator, splat(1.0F));
        const Floats du =
            __builtin_convertvector(kLaneNumbers, Floats) + (static_cast<float>(u) - optics.cx);
        const Floats plane_x = optics.focal * slope_u;
        const Floats plane_y = optics.focal * slope_v;
        const Floats plane_z = d - du * slope_u - row.v * slope_v;
        const Floats length =
            square_root(plane_x * plane_x + plane_y * plane_y + plane_z * plane_z);
        const Floats ray =
            square_root(du * du + (row.v * row.v + optics.focal * optics.focal)) / optics.focal;
        const Floats cosine = d / (length * ray);
        good &= cosine >= kLeastCosine;
        const Floats ramp =
            least_of(splat(1.0F), (inside - kDeadRim_px) / (kFullWeight_px - kDeadRim_px));
        Floats fields[kLanes] = {where(good, plane_x / length),
                                 where(good, plane_y / length),
                                 where(good, plane_z / length),
                                 where(good, optics.focal_baseline / length),
                                 where(good, load(row.sigma + u)),
                                 where(good, optics.focal_baseline / d),
                                 where(good, cosine * ramp),
                                 where(good, reinterpret_cast<Floats>(colors(row.image + 3 * u)))};
        transpose(fields);
        std::memcpy(pixels + u, fields, sizeof fields);
    }
}

struct Kernels {
    void (*mark_inside)(const float*, const float*, const float*, int, std::uint8_t*);
    void (*fit_planes)(const DepthRow&, const Optics&, SurfacePixel*);
};

void mark_inside(
    const float* above, const float* row, const float* below, int width, std::uint8_t* inside) {
    mark_inside_body(above, row, below, width, inside);
}
DIVEMESH_FOR_AVX2 void mark_inside_avx2(
    const float* above, const float* row, const float* below, int width, std::uint8_t* inside) {
    mark_inside_body(above, row, below, width, inside);
}
void fit_planes(const DepthRow& row, const Optics& optics, SurfacePixel* pixels) {
    fit_planes_body(row, optics, pixels);
}
DIVEMESH_FOR_AVX2 void fit_planes_avx2(const DepthRow& row,
                                       const Optics& optics,
                                       SurfacePixel* pixels) {
    fit_planes_body(row, optics, pixels);
}

// Distance of each known pixel from the nearest unknown one or jump, px.
cv::Mat distance_from_rim(const cv::Mat& disparity, const Kernels& kernels) {
    cv::Mat inside(disparity.size(), CV_8U, cv::Scalar(0));
    for (int y = 1; y + 1 < disparity.rows; ++y)
        kernels.mark_inside(disparity.ptr<float>(y - 1),
                            disparity.ptr<float>(y),
                            disparity.ptr<float>(y + 1),
                            disparity.cols,
                            inside.ptr<std::uint8_t>(y));
    cv::Mat distance;
    cv::distanceTransform(inside, distance, cv::DIST_L2, 3);
    return distance;
}

}  // namespace

DepthView::DepthView(const RectifiedRig& rig,
                     const KeyframeImages& images,
                     int num_threads,
                     Instructions instructions)
    : width_px_(images.depth.disparity_px.cols),
      height_px_(images.depth.disparity_px.rows),
      pixels_(images.depth.disparity_px.total()) {
    const DepthMap& depth = images.depth;
    if (width_px_ < 2 * kReach_px + kLanes || height_px_ <= 2 * kReach_px) return;
    const Kernels kernels = instructions == Instructions::Baseline
                                ? Kernels{mark_inside, fit_planes}
                                : Kernels{mark_inside_avx2, fit_planes_avx2};
    const cv::Mat rim = distance_from_rim(depth.disparity_px, kernels);
    const Optics optics{static_cast<float>(rig.focal_px),
                        static_cast<float>(rig.focal_px * rig.baseline_m),
                        static_cast<float>(rig.cx_px)};
    const auto num_rows = static_cast<std::size_t>(height_px_ - 2 * kReach_px);
    for_each_index(num_threads, num_rows, [&](std::size_t i) {
        const int v = static_cast<int>(i) + kReach_px;
        const DepthRow row{depth.disparity_px.ptr<float>(v),
                           static_cast<std::ptrdiff_t>(depth.disparity_px.step1()),
                           depth.sigma_disparity_px.ptr<float>(v),
                           rim.ptr<float>(v),
                           images.left_color.ptr<std::uint8_t>(v),
                           width_px_,
                           static_cast<float>(v - rig.cy_px)};
        kernels.fit_planes(row, optics, pixels_.data() + static_cast<std::size_t>(v) * width_px_);
    });
}

}  // namespace divemesh::worker
