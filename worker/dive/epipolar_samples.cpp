#include "worker/dive/epipolar_samples.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "worker/camera/projection.hpp"

namespace divemesh::dive {
namespace {

constexpr int kMaxCorners = 250;
constexpr double kMaxBackError_px = 0.7;  // between a corner and where it is tracked back to
constexpr double kNearest_1_m = 20.0;     // inverse depths beyond these are mismatches
constexpr double kFarthest_1_m = 0.02;

using Points = std::vector<cv::Point2f>;

// Tracks points of `from` into `to`; clears `found` for those that do not track back to their
// start.
Points track(const cv::Mat& from,
             const cv::Mat& to,
             const Points& points,
             std::vector<bool>& found) {
    const cv::Size window(21, 21);
    Points there;
    Points back;
    std::vector<unsigned char> went;
    std::vector<unsigned char> came;
    cv::calcOpticalFlowPyrLK(from, to, points, there, went, cv::noArray(), window, 5);
    cv::calcOpticalFlowPyrLK(to, from, there, back, came, cv::noArray(), window, 5);
    for (std::size_t i = 0; i < points.size(); ++i)
        if (went[i] == 0 || came[i] == 0 || cv::norm(back[i] - points[i]) > kMaxBackError_px)
            found[i] = false;
    return there;
}

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

class Geometry {
public:
    explicit Geometry(const types::Rig& rig)
        : rig_(rig),
          T_cam0_cam1_(rig.T_cam1_cam0().inverse()),
          baseline_(T_cam0_cam1_.translation()) {}

    Eigen::Vector3d left_ray(const cv::Point2f& pixel) const {
        return camera::unproject(rig_.cam0, {pixel.x, pixel.y});
    }
    Eigen::Vector3d right_ray(const cv::Point2f& pixel) const {
        return T_cam0_cam1_.linear() * camera::unproject(rig_.cam1, {pixel.x, pixel.y});
    }
    // Signed angle between the right ray and the epipolar plane of the left ray, as pixels.
    double error_px(const Eigen::Vector3d& left, const Eigen::Vector3d& right) const {
        return baseline_.cross(left).normalized().dot(right.normalized()) * rig_.cam0.fx_px;
    }
    // From z * left x right = baseline x right; negative if the rays meet behind the cameras.
    double inverse_depth_1_m(const Eigen::Vector3d& left, const Eigen::Vector3d& right) const {
        const Eigen::Vector3d b = baseline_.cross(right);
        return left.cross(right).dot(b) / b.squaredNorm();
    }
    double focal_px() const { return rig_.cam0.fx_px; }
    Eigen::Vector2d baseline_direction() const { return baseline_.head<2>().normalized(); }

private:
    const types::Rig& rig_;
    Eigen::Isometry3d T_cam0_cam1_;
    Eigen::Vector3d baseline_;  // m, in cam0
};

}  // namespace

EpipolarMoment sample_epipolar_errors(const types::Rig& rig,
                                      const cv::Mat& left,
                                      const cv::Mat& right,
                                      const cv::Mat& later,
                                      double interval_s) {
    EpipolarMoment moment;
    Points corners;
    cv::goodFeaturesToTrack(left, corners, kMaxCorners, 0.01, 12.0);
    moment.num_corners = static_cast<int>(corners.size());
    if (corners.empty()) return moment;
    std::vector<bool> found(corners.size(), true);
    const Points in_right = track(left, exposed_like(right, left), corners, found);
    const Points in_later = track(left, exposed_like(later, left), corners, found);
    const Geometry geometry(rig);
    for (std::size_t i = 0; i < corners.size(); ++i) {
        if (!found[i]) continue;
        const Eigen::Vector3d ray = geometry.left_ray(corners[i]);
        const Eigen::Vector3d later_ray = geometry.left_ray(in_later[i]);
        const Eigen::Vector3d right_ray = geometry.right_ray(in_right[i]);
        const double inverse_depth = geometry.inverse_depth_1_m(ray, right_ray);
        if (!(inverse_depth > kFarthest_1_m && inverse_depth < kNearest_1_m)) continue;
        EpipolarSample sample;
        sample.ray = ray.head<2>();
        sample.error_px = geometry.error_px(ray, right_ray);
        sample.rate_px_s = (sample.error_px - geometry.error_px(later_ray, right_ray)) / interval_s;
        const Eigen::Vector2d flow = (later_ray - ray).head<2>() / interval_s;
        sample.flow_px_s = flow.dot(geometry.baseline_direction()) * geometry.focal_px();
        sample.speed_m_s = flow.norm() / inverse_depth;
        moment.samples.push_back(sample);
    }
    return moment;
}

}  // namespace divemesh::dive
