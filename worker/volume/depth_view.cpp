#include "worker/volume/depth_view.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace divemesh::worker {
namespace {

constexpr float kLargestSlope = 1.0F;  // of disparity per pixel; steeper is a jump
constexpr int kReach_px = 4;           // of the gradient
constexpr float kDeadRim_px = 2.0F;
constexpr float kFullWeight_px = 5.0F;  // from a jump or the unknown
constexpr float kLeastCosine = 0.15F;   // of the angle of incidence

// Distance of each known pixel from the nearest unknown one or jump, px.
cv::Mat distance_from_rim(const cv::Mat& disparity) {
    cv::Mat inside(disparity.size(), CV_8U, cv::Scalar(0));
    for (int y = 1; y + 1 < disparity.rows; ++y) {
        const float* above = disparity.ptr<float>(y - 1);
        const float* row = disparity.ptr<float>(y);
        const float* below = disparity.ptr<float>(y + 1);
        std::uint8_t* out = inside.ptr<std::uint8_t>(y);
        for (int x = 1; x + 1 < disparity.cols; ++x) {
            const float d = row[x];
            const auto near = [&](float other) { return std::abs(other - d) < kLargestSlope; };
            out[x] = d > 0.0F && near(row[x - 1]) && near(row[x + 1]) && near(above[x]) &&
                     near(below[x]);
        }
    }
    cv::Mat distance;
    cv::distanceTransform(inside, distance, cv::DIST_L2, 3);
    return distance;
}

// Slope of the disparity along one axis: differences of pixels on opposite sides, of those pairs
// that are on one plane with the centre.
class SlopeFit {
public:
    explicit SlopeFit(float center) : center_(center) {}
    void add(float ahead, float behind, int reach_px) {
        const auto reach = static_cast<float>(reach_px);
        if (ahead <= 0.0F || behind <= 0.0F ||
            std::abs(ahead - behind) > 2.0F * kLargestSlope * reach ||
            std::abs(ahead + behind - 2.0F * center_) > 1.0F)
            return;
        numerator_ += 2.0F * reach * (ahead - behind);
        denominator_ += 4.0F * reach * reach;
    }
    bool known() const { return denominator_ > 0.0F; }
    float slope() const { return numerator_ / denominator_; }

private:
    float center_;
    float numerator_ = 0.0F;
    float denominator_ = 0.0F;
};

// The tangent plane at a pixel: n ~ (f d_u, f d_v, d - (u - cx) d_u - (v - cy) d_v), scaled so that
// n . p = f b on the plane.
bool fit_plane(const RectifiedRig& rig, const cv::Mat& disparity, int u, int v, SurfacePixel& out) {
    const float d = disparity.at<float>(v, u);
    SlopeFit along_u(d), along_v(d);
    for (int reach = 2; reach <= kReach_px; reach += 2)
        for (int side = -kReach_px; side <= kReach_px; side += kReach_px) {
            along_u.add(disparity.at<float>(v + side, u + reach),
                        disparity.at<float>(v - side, u - reach),
                        reach);
            along_v.add(disparity.at<float>(v + reach, u + side),
                        disparity.at<float>(v - reach, u - side),
                        reach);
        }
    if (!along_u.known() || !along_v.known()) return false;
    const auto focal = static_cast<float>(rig.focal_px);
    const float du = static_cast<float>(u - rig.cx_px), dv = static_cast<float>(v - rig.cy_px);
    const Eigen::Vector3f plane(focal * along_u.slope(),
                                focal * along_v.slope(),
                                d - du * along_u.slope() - dv * along_v.slope());
    const float length = plane.norm();
    const float ray = std::sqrt(du * du + dv * dv + focal * focal) / focal;
    const float cosine = d / (length * ray);
    if (cosine < kLeastCosine) return false;
    const auto focal_baseline = static_cast<float>(rig.focal_px * rig.baseline_m);
    out.normal = plane / length;
    out.offset_m = focal_baseline / length;
    out.depth_m = focal_baseline / d;
    out.weight = cosine;
    return true;
}

}  // namespace

DepthView::DepthView(const RectifiedRig& rig, const DepthMap& depth)
    : width_px_(depth.disparity_px.cols),
      height_px_(depth.disparity_px.rows),
      pixels_(depth.disparity_px.total()) {
    const cv::Mat rim = distance_from_rim(depth.disparity_px);
    for (int v = kReach_px; v < height_px_ - kReach_px; ++v)
        for (int u = kReach_px; u < width_px_ - kReach_px; ++u) {
            const float inside = rim.at<float>(v, u);
            if (inside <= kDeadRim_px) continue;
            SurfacePixel& pixel = pixels_[static_cast<std::size_t>(v) * width_px_ + u];
            if (!fit_plane(rig, depth.disparity_px, u, v, pixel)) continue;
            pixel.weight *= std::min(1.0F, (inside - kDeadRim_px) / (kFullWeight_px - kDeadRim_px));
            pixel.sigma_disparity_px = depth.sigma_disparity_px.at<float>(v, u);
        }
}

}  // namespace divemesh::worker
