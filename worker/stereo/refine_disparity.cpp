#include "worker/stereo/refine_disparity.hpp"

#include "worker/stereo/fill_holes.hpp"
#include "worker/stereo/smooth_on_plane.hpp"

namespace divemesh::stereo {
namespace {

constexpr float kFirstGate_px = 0.8F;
constexpr float kSecondGate_px = 0.4F;

}  // namespace

cv::Mat DisparityRefiner::refine(const cv::Mat& left, const cv::Mat& right, cv::Mat& disparity_px) {
    if (left.cols < kWindow_px || left.rows < kWindow_px) {
        disparity_px.setTo(0.0);
        return {disparity_px.size(), CV_32F, cv::Scalar(0.0)};
    }
    one_px_.copy_from(disparity_px);
    fill_holes(one_px_, other_px_, instructions_);
    smooth_on_plane(one_px_, kFirstGate_px, other_px_, instructions_);
    step_.take(left, right, other_px_, sigma_px_);
    smooth_on_plane(other_px_, kSecondGate_px, one_px_, instructions_);
    smooth_uncertain(one_px_, sigma_px_, other_px_, smooth_sigma_px_, instructions_);
    cv::Mat sigma_px = smooth_sigma_px_.to_mat();
    for (int y = 0; y < disparity_px.rows; ++y) {
        const float* smooth = other_px_.row(y);
        const float* sigma = sigma_px.ptr<float>(y);
        float* out = disparity_px.ptr<float>(y);
        for (int x = 0; x < disparity_px.cols; ++x) out[x] = sigma[x] > 0.0F ? smooth[x] : 0.0F;
    }
    return sigma_px;
}

}  // namespace divemesh::stereo
