#include "worker/camera/synchronise_pair.hpp"

#include <opencv2/imgproc.hpp>

#include "worker/base/rotation_vector.hpp"

namespace divemesh::camera {
namespace {

// Returns the homography that maps pixels of a right image of the left one's time to those of the
// late one, for points at the compensated disparity.
Eigen::Matrix3d homography(const types::ExposureMotion& between) {
    const types::RectifiedRig& rig = between.rig;
    Eigen::Matrix3d K = Eigen::Matrix3d::Identity();
    K(0, 0) = K(1, 1) = rig.focal_px;
    K(0, 2) = rig.cx_px;
    K(1, 2) = rig.cy_px;
    const Eigen::Vector3d right_translation_m =
        between.translation_m +
        between.rotation_rad.cross(Eigen::Vector3d(rig.baseline_m, 0.0, 0.0));
    Eigen::Matrix3d motion = Eigen::Matrix3d::Identity() + base::cross_matrix(between.rotation_rad);
    motion.col(2) += right_translation_m / rig.depth_m(between.compensated_disparity_px);
    return K * motion * K.inverse();
}

}  // namespace

types::ExposureMotion exposure_motion(const types::RectifiedRig& rig,
                                      const Eigen::Isometry3d& T_current_previous,
                                      double share,
                                      double compensated_disparity_px) {
    const Eigen::Vector3d rotation_rad =
        base::vector_from_rotation(Eigen::Quaterniond(T_current_previous.linear()));
    const Eigen::Vector3d t = T_current_previous.translation();
    // The translation of the twist, to second order.
    return {rig,
            share * rotation_rad,
            share * (t - 0.5 * rotation_rad.cross(t)),
            compensated_disparity_px};
}

types::RectifiedFrame synchronise_pair(const types::RectifiedFrame& frame,
                                       const std::optional<types::ExposureMotion>& between) {
    if (!between) return frame;
    types::RectifiedFrame result = frame;
    const Eigen::Matrix3d H = homography(*between);
    const cv::Matx33d late_right(
        H(0, 0), H(0, 1), H(0, 2), H(1, 0), H(1, 1), H(1, 2), H(2, 0), H(2, 1), H(2, 2));
    result.right = cv::Mat();
    cv::warpPerspective(frame.right,
                        result.right,
                        late_right,
                        frame.right.size(),
                        cv::INTER_CUBIC | cv::WARP_INVERSE_MAP,
                        cv::BORDER_REPLICATE);
    result.between = between;
    return result;
}

void correct_disparities(const types::RectifiedFrame& frame, types::DepthMap& depth) {
    if (frame.is_ideal()) return;
    for (int v = 0; v < depth.disparity_px.rows; ++v) {
        auto* row = depth.disparity_px.ptr<float>(v);
        for (int u = 0; u < depth.disparity_px.cols; ++u)
            if (row[u] > 0.0F)
                row[u] = static_cast<float>(frame.disparity_px(Eigen::Vector2d(u, v), row[u]));
    }
}

}  // namespace divemesh::camera
