#include "worker/camera/shutter_correction.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "worker/base/parallel.hpp"
#include "worker/base/rotation_vector.hpp"
#include "worker/camera/resampled_by_depth.hpp"

namespace divemesh::camera {
namespace {

constexpr int kNumIterations = 2;

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
    if (motion == motions_.end()) return images;
    const auto late_s = [&](float x, float y) {
        const int column = std::clamp(static_cast<int>(std::lround(x)), 0, late_s_.cols - 1);
        const int row = std::clamp(static_cast<int>(std::lround(y)), 0, late_s_.rows - 1);
        return late_s_.at<float>(row, column);
    };
    return resampled_by_depth(
        images,
        kNumIterations,
        [&](int u, int v, float x, float y, float disparity_px) -> Eigen::Vector3f {
            const Eigen::Vector3d p_cam =
                rig_.point_cam(u, v, rig_.depth_m(static_cast<double>(disparity_px)));
            return late_s(x, y) * shutter_.flow_px_s(motion->second, p_cam).cast<float>();
        });
}

}  // namespace divemesh::camera
