#include "worker/fusion/depth_view.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "worker/base/lanes.hpp"
#include "worker/fusion/close_pinholes.hpp"
#include "worker/fusion/mark_bridges.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::fusion {
namespace {

constexpr float kMaxSlope = 1.0F;    // of disparity per pixel; steeper is a discontinuity
constexpr int kReach_px = 4;         // of the gradient's pixels, at full sampling
constexpr float kMaxBend_px = 1.0F;  // of the disparity over that reach
constexpr float kDeadRim_px = 1.0F;
constexpr float kFullWeight_px = 5.0F;  // distance from farther surface or an unknown pixel
constexpr float kMinCosine = 0.04F;     // of the angle of incidence

DIVEMESH_INLINE_BODY void mark_inside(const float* __restrict above,
                                      const float* __restrict row,
                                      const float* __restrict below,
                                      int width,
                                      std::uint8_t* __restrict inside) {
    for (int x = 1; x + 1 < width; ++x) {
        const float d = row[x];
        const int is_inside = static_cast<int>(d - row[x - 1] < kMaxSlope) &
                              static_cast<int>(d - row[x + 1] < kMaxSlope) &
                              static_cast<int>(d - above[x] < kMaxSlope) &
                              static_cast<int>(d - below[x] < kMaxSlope) &
                              static_cast<int>(d > 0.0F);
        inside[x] = static_cast<std::uint8_t>(is_inside);
    }
}

// Slope of the disparity along one axis: differences of opposite pixels, for those pairs that are
// in one plane with the centre.
struct SlopeFit {
    base::Floats numerator;
    base::Floats denominator;
};

DIVEMESH_INLINE_BODY void add_pair(SlopeFit& fit,
                                   base::Floats center,
                                   base::Floats ahead,
                                   base::Floats behind,
                                   int reach_px,
                                   float bend_px) {
    const auto reach = static_cast<float>(reach_px);
    const base::Masks on_plane = (ahead > 0.0F) & (behind > 0.0F) &
                                 (base::abs(ahead - behind) <= 2.0F * kMaxSlope * reach) &
                                 (base::abs(ahead + behind - 2.0F * center) <= bend_px);
    fit.numerator += base::select(on_plane, 2.0F * reach * (ahead - behind));
    fit.denominator += base::select(on_plane, base::broadcast(4.0F * reach * reach));
}

// One row of a keyframe's depth with access to the rows around it.
struct DepthRow {
    const float* disparity;  // of the row; the next row is `stride` floats further
    std::ptrdiff_t stride;
    const float* sigma;
    const float* rim;           // distance from the nearest unknown pixel or farther surface
    const std::uint8_t* image;  // BGR
    int width;
    float v;  // of the row, from the principal point
};

struct Optics {
    float focal;
    float focal_baseline;
    float cx;
    int step_px;  // keyframe pixels per pixel
};

// Returns the colours of eight pixels: red, green and blue from bit 16 down. Reads one byte past
// them, so it must not be used for the last pixels.
DIVEMESH_INLINE_BODY base::Masks colors(const std::uint8_t* bgr) {
    base::Masks packed;
    for (int i = 0; i < base::kLanes; ++i) {
        const int first = 3 * i;
        std::uint32_t four;
        std::memcpy(&four, bgr + first, sizeof four);
        packed[i] = static_cast<std::int32_t>(four & 0xffffff);
    }
    return packed;
}

// Fits the tangent planes of a row: n ~ (f d_u, f d_v, d - (u - cx) d_u - (v - cy) d_v), scaled so
// that n . p = f b on the plane.
DIVEMESH_INLINE_BODY void fit_planes(const DepthRow& row,
                                     const Optics& optics,
                                     SurfacePixel* pixels) {
    const int furthest = kReach_px / optics.step_px;
    const float bend_px = kMaxBend_px / static_cast<float>(optics.step_px);
    for (int start = furthest; start < row.width - furthest; start += base::kLanes) {
        // The last eight pixels overlap the previous ones.
        const int u = std::min(start, row.width - furthest - base::kLanes);
        const base::Floats inside = static_cast<float>(optics.step_px) * base::load(row.rim + u);
        base::Masks good = inside > kDeadRim_px;
        if (!base::any(good)) continue;
        const float* at = row.disparity + u;
        const base::Floats d = base::load(at);
        SlopeFit along_u{};
        SlopeFit along_v{};
        for (int reach = furthest / 2; reach <= furthest; reach += furthest / 2)
            for (int side = -furthest; side <= furthest; side += furthest) {
                const std::ptrdiff_t rows_u = side * row.stride;
                const std::ptrdiff_t rows_v = reach * row.stride;
                const base::Floats right = base::load(at + rows_u + reach);
                const base::Floats left = base::load(at - rows_u - reach);
                const base::Floats below = base::load(at + rows_v + side);
                const base::Floats above = base::load(at - rows_v - side);
                add_pair(along_u, d, right, left, reach, bend_px);
                add_pair(along_v, d, below, above, reach, bend_px);
            }
        good &= (along_u.denominator > 0.0F) & (along_v.denominator > 0.0F);
        const base::Floats slope_u =
            along_u.numerator / base::max(along_u.denominator, base::broadcast(1.0F));
        const base::Floats slope_v =
            along_v.numerator / base::max(along_v.denominator, base::broadcast(1.0F));
        const base::Floats du = __builtin_convertvector(base::kLaneNumbers, base::Floats) +
                                (static_cast<float>(u) - optics.cx);
        const base::Floats plane_x = optics.focal * slope_u;
        const base::Floats plane_y = optics.focal * slope_v;
        const base::Floats plane_z = d - du * slope_u - row.v * slope_v;
        const base::Floats length =
            base::square_root(plane_x * plane_x + plane_y * plane_y + plane_z * plane_z);
        const base::Floats ray =
            base::square_root(du * du + (row.v * row.v + optics.focal * optics.focal)) /
            optics.focal;
        const base::Floats cosine = d / (length * ray);
        good &= cosine >= kMinCosine;
        const base::Floats ramp = base::min(
            base::broadcast(1.0F), (inside - kDeadRim_px) / (kFullWeight_px - kDeadRim_px));
        const int first_byte = 3 * u;
        base::Floats fields[base::kLanes] = {
            base::select(good, plane_x / length),
            base::select(good, plane_y / length),
            base::select(good, plane_z / length),
            base::select(good, optics.focal_baseline / length),
            base::select(good, base::load(row.sigma + u)),
            base::select(good, optics.focal_baseline / d),
            base::select(good, cosine * ramp),
            base::select(good, reinterpret_cast<base::Floats>(colors(row.image + first_byte)))};
        base::transpose(fields);
        std::memcpy(pixels + u, fields, sizeof fields);
    }
}

struct Kernels {
    void (*mark_inside)(const float*, const float*, const float*, int, std::uint8_t*);
    void (*fit_planes)(const DepthRow&, const Optics&, SurfacePixel*);
};

// Erodes a row by one pixel. Calls alternate between erosion with and without the corners, which
// proceeds about as fast diagonally as along the axes.
void peel_row(const std::uint8_t* __restrict above,
              const std::uint8_t* __restrict row,
              const std::uint8_t* __restrict below,
              int width,
              bool with_corners,
              std::uint8_t* __restrict out) {
    for (int x = 1; x + 1 < width; ++x)
        out[x] = row[x - 1] & row[x] & row[x + 1] & above[x] & below[x];
    if (!with_corners) return;
    for (int x = 1; x + 1 < width; ++x)
        out[x] &= above[x - 1] & above[x + 1] & below[x - 1] & below[x + 1];
}

// Returns the distance of each pixel from the nearest one that is unknown or beside farther
// surface, px, limited to the largest distance that matters. The farther surface itself goes up to
// the edge: a matcher makes the nearer one too wide.
cv::Mat distance_from_rim(const cv::Mat& disparity, const Kernels& kernels) {
    cv::Mat inside(disparity.size(), CV_8U, cv::Scalar(0));
    for (int y = 1; y + 1 < disparity.rows; ++y)
        kernels.mark_inside(disparity.ptr<float>(y - 1),
                            disparity.ptr<float>(y),
                            disparity.ptr<float>(y + 1),
                            disparity.cols,
                            inside.ptr<std::uint8_t>(y));
    cv::Mat layers = inside.clone();
    cv::Mat peeled(disparity.size(), CV_8U, cv::Scalar(0));
    for (int layer = 1; static_cast<float>(layer) < kFullWeight_px; ++layer) {
        for (int y = 1; y + 1 < inside.rows; ++y)
            peel_row(inside.ptr<std::uint8_t>(y - 1),
                     inside.ptr<std::uint8_t>(y),
                     inside.ptr<std::uint8_t>(y + 1),
                     inside.cols,
                     layer % 2 == 0,
                     peeled.ptr<std::uint8_t>(y));
        std::swap(inside, peeled);
        layers += inside;
    }
    cv::Mat distance;
    layers.convertTo(distance, CV_32F);
    return distance;
}

// The input of the plane fit.
struct DepthImage {
    cv::Mat disparity;  // CV_32F
    cv::Mat sigma;      // CV_32F
    cv::Mat rim;        // CV_32F, distance from the nearest pixel outside a surface
    cv::Mat color;      // CV_8UC3
};

// Averages 2 x 2 pixels, with the disparity in units of the larger pixels; 0 where a disparity is
// unknown.
void halve_row(const DepthImage& from, int row, DepthImage& to) {
    const auto* above = from.disparity.ptr<float>(2 * row);
    const auto* below = from.disparity.ptr<float>(2 * row + 1);
    const auto mean_of = [&](const cv::Mat& values, std::ptrdiff_t x) {
        const auto* first = values.ptr<float>(2 * row) + 2 * x;
        const auto* second = values.ptr<float>(2 * row + 1) + 2 * x;
        return 0.25F * ((first[0] + first[1]) + (second[0] + second[1]));
    };
    auto* disparity = to.disparity.ptr<float>(row);
    auto* sigma = to.sigma.ptr<float>(row);
    auto* rim = to.rim.ptr<float>(row);
    for (std::ptrdiff_t x = 0; x < to.disparity.cols; ++x) {
        const float min_disparity = std::min(std::min(above[2 * x], above[2 * x + 1]),
                                             std::min(below[2 * x], below[2 * x + 1]));
        disparity[x] = min_disparity > 0.0F ? 0.5F * mean_of(from.disparity, x) : 0.0F;
        sigma[x] = 0.5F * mean_of(from.sigma, x);
        rim[x] = 0.5F * mean_of(from.rim, x);
    }
}

DepthImage halved(const DepthImage& full) {
    const cv::Size size(full.disparity.cols / 2, full.disparity.rows / 2);
    DepthImage half{cv::Mat(size, CV_32F), cv::Mat(size, CV_32F), cv::Mat(size, CV_32F), {}};
    for (int row = 0; row < size.height; ++row) halve_row(full, row, half);
    const cv::Rect whole(0, 0, 2 * size.width, 2 * size.height);
    cv::resize(full.color(whole), half.color, size, 0.0, 0.0, cv::INTER_AREA);
    return half;
}

// The centre of 2 x 2 pixels is half a pixel to the right of and below the first pixel's centre.
types::RectifiedRig halved(types::RectifiedRig rig) {
    rig.width_px /= 2;
    rig.height_px /= 2;
    rig.focal_px /= 2.0;
    rig.cx_px = (rig.cx_px - 0.5) / 2.0;
    rig.cy_px = (rig.cy_px - 0.5) / 2.0;
    return rig;
}

}  // namespace

float median_disparity_px(const types::DepthMap& depth) {
    constexpr int kStep_px = 8;
    std::vector<float> disparities;
    for (int v = 0; v < depth.disparity_px.rows; v += kStep_px)
        for (int u = 0; u < depth.disparity_px.cols; u += kStep_px) {
            const float disparity = depth.disparity_px.at<float>(v, u);
            if (disparity > 0.0F) disparities.push_back(disparity);
        }
    return stats::upper_median(std::move(disparities));
}

Sampling choose_sampling(const types::RectifiedRig& rig,
                         const types::DepthMap& depth,
                         double voxel_m) {
    constexpr double kPixels = 2.0;
    const float disparity_px = median_disparity_px(depth);
    return disparity_px * voxel_m / rig.baseline_m >= kPixels ? Sampling::Half : Sampling::Full;
}

DepthView::DepthView(const types::RectifiedRig& rig,
                     const types::KeyframeImages& images,
                     Sampling sampling,
                     base::Instructions instructions)
    : step_px_(sampling == Sampling::Half ? 2 : 1),
      rig_(sampling == Sampling::Half ? halved(rig) : rig),
      image_(images.left_color),
      pixels_(static_cast<std::size_t>(rig_.width_px) * rig_.height_px) {
    const int reach = kReach_px / step_px_;
    if (images.depth.disparity_px.empty() || rig_.width_px < 2 * reach + base::kLanes ||
        rig_.height_px <= 2 * reach)
        return;
    const Kernels kernels{base::compiled_for<mark_inside>(instructions),
                          base::compiled_for<fit_planes>(instructions)};
    cv::Mat disparity_px = images.depth.disparity_px.clone();
    cv::Mat sigma_px = images.depth.sigma_disparity_px.clone();
    close_pinholes(disparity_px, sigma_px);
    DepthImage image{
        disparity_px, sigma_px, distance_from_rim(disparity_px, kernels), images.left_color};
    mark_bridges(disparity_px, sigma_px, rig.focal_px, instructions, image.rim);
    if (sampling == Sampling::Half) image = halved(image);
    const Optics optics{static_cast<float>(rig_.focal_px),
                        static_cast<float>(rig_.focal_px * rig_.baseline_m),
                        static_cast<float>(rig_.cx_px),
                        step_px_};
    for (int v = reach; v < rig_.height_px - reach; ++v) {
        const DepthRow row{image.disparity.ptr<float>(v),
                           static_cast<std::ptrdiff_t>(image.disparity.step1()),
                           image.sigma.ptr<float>(v),
                           image.rim.ptr<float>(v),
                           image.color.ptr<std::uint8_t>(v),
                           rig_.width_px,
                           static_cast<float>(v - rig_.cy_px)};
        kernels.fit_planes(
            row, optics, pixels_.data() + static_cast<std::size_t>(v) * rig_.width_px);
    }
}

}  // namespace divemesh::fusion
