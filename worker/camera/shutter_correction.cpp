#include "worker/camera/shutter_correction.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "worker/base/parallel.hpp"
#include "worker/base/rotation_vector.hpp"
#include "worker/camera/disparity_at.hpp"

namespace divemesh::camera {
namespace {

// The disparity of the source pixel is that of the target pixel at first.
constexpr int kNumIterations = 2;

float mean_disparity_px(const cv::Mat& disparity) {
    return disparity.empty() ? 0.0F : static_cast<float>(cv::mean(disparity, disparity > 0.0)[0]);
}

// Returns 0 if the pixel is outside of the image or has no disparity.
float nearest_disparity(const cv::Mat& disparity, float u, float v) {
    const auto column = static_cast<int>(std::lround(u));
    const auto row = static_cast<int>(std::lround(v));
    if (column < 0 || row < 0 || column >= disparity.cols || row >= disparity.rows) return 0.0F;
    return disparity.at<float>(row, column);
}

}  // namespace

ShutterCorrection::ShutterCorrection(const types::RectifiedRig& rig,
                                     const RectifiedLens& left,
                                     double readout_time_s,
                                     std::map<int, CameraMotion> motions,
                                     int num_threads)
    : rig_(rig),
      shutter_(rig, left),
      readout_time_s_(readout_time_s),
      motions_(std::move(motions)),
      late_s_(rig.height_px, rig.width_px, CV_32F) {
    base::for_each_index(
        num_threads, static_cast<std::size_t>(rig.height_px), [&](std::size_t row) {
            const int v = static_cast<int>(row);
            for (int u = 0; u < rig.width_px; ++u)
                late_s_.at<float>(v, u) =
                    static_cast<float>(readout_time_s * shutter_.row_share(Eigen::Vector2d(u, v)));
        });
}

Eigen::Isometry3d ShutterCorrection::motion_until_row(int frame_index,
                                                      const Eigen::Vector2d& seen_px) const {
    Eigen::Isometry3d T_middle_row = Eigen::Isometry3d::Identity();
    const auto motion = motions_.find(frame_index);
    if (motion == motions_.end()) return T_middle_row;
    const double late_s = readout_time_s_ * shutter_.row_share(seen_px);
    T_middle_row.linear() =
        base::rotation_from_vector(late_s * motion->second.angular_velocity_cam).toRotationMatrix();
    T_middle_row.translation() = late_s * motion->second.velocity_cam;
    return T_middle_row;
}

types::KeyframeImages ShutterCorrection::moved(int frame_index,
                                               const types::KeyframeImages& images) const {
    const auto motion = motions_.find(frame_index);
    const cv::Mat& disparity = images.depth.disparity_px;
    const float mean_px = mean_disparity_px(disparity);
    if (motion == motions_.end() || mean_px <= 0.0F) return images;
    types::KeyframeImages result;
    result.depth.disparity_px = cv::Mat::zeros(disparity.size(), CV_32F);
    result.depth.sigma_disparity_px = cv::Mat::zeros(disparity.size(), CV_32F);
    cv::Mat source_x(disparity.size(), CV_32F);
    cv::Mat source_y(disparity.size(), CV_32F);
    const auto late_s = [&](float x, float y) {
        const int column = std::clamp(static_cast<int>(std::lround(x)), 0, disparity.cols - 1);
        const int row = std::clamp(static_cast<int>(std::lround(y)), 0, disparity.rows - 1);
        return late_s_.at<float>(row, column);
    };
    for (int v = 0; v < disparity.rows; ++v) {
        for (int u = 0; u < disparity.cols; ++u) {
            float& x = source_x.at<float>(v, u);
            float& y = source_y.at<float>(v, u);
            x = static_cast<float>(u);
            y = static_cast<float>(v);
            float seen_px = 0.0F;
            float shift_px = 0.0F;  // of the disparity
            for (int i = 0; i < kNumIterations; ++i) {
                const float known_px = nearest_disparity(disparity, x, y);
                const float used_px = known_px > 0.0F ? known_px : mean_px;
                const Eigen::Vector3d p_cam =
                    rig_.point_cam(u, v, rig_.depth_m(static_cast<double>(used_px)));
                const Eigen::Vector3f shift =
                    late_s(x, y) * shutter_.flow_px_s(motion->second, p_cam).cast<float>();
                x = static_cast<float>(u) + shift.x();
                y = static_cast<float>(v) + shift.y();
                seen_px = nearest_disparity(disparity, x, y);
                shift_px = shift.z();
            }
            if (seen_px <= 0.0F) continue;
            const float moved_px = disparity_at(disparity, x, y, seen_px) - shift_px;
            if (moved_px <= 0.0F) continue;
            result.depth.disparity_px.at<float>(v, u) = moved_px;
            result.depth.sigma_disparity_px.at<float>(v, u) =
                nearest_disparity(images.depth.sigma_disparity_px, x, y);
        }
    }
    if (!images.left_color.empty())
        cv::remap(images.left_color, result.left_color, source_x, source_y, cv::INTER_LINEAR);
    return result;
}

}  // namespace divemesh::camera
