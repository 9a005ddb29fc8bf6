#include "worker/dive/epipolar_samples.hpp"

#include <Eigen/Geometry>
#include <opencv2/imgproc.hpp>

#include "worker/dive/smooth_rates.hpp"
#include "worker/dive/stereo_rays.hpp"
#include "worker/dive/track_corners.hpp"

namespace divemesh::dive {
namespace {

constexpr int kMaxCorners = 250;
constexpr double kMaxInverseDepth_1_m = 20.0;  // inverse depths beyond these are mismatches
constexpr double kMinInverseDepth_1_m = 0.02;

// Returns `image` with the mean and contrast of `like`, as cameras expose by themselves.
cv::Mat exposed_like(const cv::Mat& image, const cv::Mat& like) {
    cv::Scalar mean;
    cv::Scalar deviation;
    cv::Scalar mean_like;
    cv::Scalar deviation_like;
    cv::meanStdDev(image, mean, deviation);
    cv::meanStdDev(like, mean_like, deviation_like);
    const double gain = deviation[0] > 0.0 ? deviation_like[0] / deviation[0] : 1.0;
    cv::Mat result;
    image.convertTo(result, CV_8U, gain, mean_like[0] - gain * mean[0]);
    return result;
}

}  // namespace

EpipolarMoment sample_epipolar_errors(const types::Rig& rig,
                                      const cv::Mat& left,
                                      const cv::Mat& right,
                                      const cv::Mat& later,
                                      double interval_s) {
    EpipolarMoment moment;
    std::vector<cv::Point2f> corners;
    cv::goodFeaturesToTrack(left, corners, kMaxCorners, 0.01, 12.0);
    moment.num_corners = static_cast<int>(corners.size());
    if (corners.empty()) return moment;
    std::vector<bool> is_in_right(corners.size(), true);
    const auto in_right = track_corners(left, exposed_like(right, left), corners, is_in_right);
    std::vector<bool> is_in_both = is_in_right;
    std::vector<cv::Point2f> in_later;
    if (later.empty())
        is_in_both.assign(corners.size(), false);
    else
        in_later = track_corners(left, exposed_like(later, left), corners, is_in_both);
    const StereoRays rays(rig);
    for (std::size_t i = 0; i < corners.size(); ++i) {
        if (!is_in_right[i]) continue;
        const Eigen::Vector3d ray = rays.left(corners[i]);
        const Eigen::Vector3d right_ray = rays.right(in_right[i]);
        const double inverse_depth = rays.inverse_depth_1_m(ray, right_ray);
        if (!(inverse_depth > kMinInverseDepth_1_m && inverse_depth < kMaxInverseDepth_1_m)) {
            ++moment.num_mismatches;
            continue;
        }
        EpipolarSample sample;
        sample.ray = ray.head<2>();
        sample.right_ray = right_ray.head<2>() / right_ray.z();
        sample.inverse_depth_1_m = inverse_depth;
        sample.error_px = rays.epipolar_error_px(ray, right_ray);
        if (!is_in_both[i]) {
            moment.without_rate.push_back(sample);
            continue;
        }
        const Eigen::Vector3d later_ray = rays.left(in_later[i]);
        sample.rate_px_s =
            (sample.error_px - rays.epipolar_error_px(later_ray, right_ray)) / interval_s;
        const Eigen::Vector2d flow = (later_ray - ray).head<2>() / interval_s;
        sample.flow_px_s = flow.dot(rays.baseline_direction()) * rig.cam0.fx_px;
        sample.speed_m_s = flow.norm() / inverse_depth;
        moment.samples.push_back(sample);
    }
    smooth_rates(moment.samples);
    return moment;
}

}  // namespace divemesh::dive
