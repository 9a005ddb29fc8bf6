#include "worker/dive/stereo_rays.hpp"

#include "worker/camera/projection.hpp"

namespace divemesh::dive {

StereoRays::StereoRays(const types::Rig& rig)
    : rig_(rig), T_cam0_cam1_(rig.T_cam1_cam0().inverse()), baseline_(T_cam0_cam1_.translation()) {}

Eigen::Vector3d StereoRays::left(const cv::Point2f& pixel) const {
    return camera::unproject(rig_.cam0, {pixel.x, pixel.y});
}

Eigen::Vector3d StereoRays::right(const cv::Point2f& pixel) const {
    return T_cam0_cam1_.linear() * camera::unproject(rig_.cam1, {pixel.x, pixel.y});
}

double StereoRays::epipolar_error_px(const Eigen::Vector3d& left,
                                     const Eigen::Vector3d& right) const {
    return baseline_.cross(left).normalized().dot(right.normalized()) * rig_.cam0.fx_px;
}

// From z * left x right = baseline x right.
double StereoRays::inverse_depth_1_m(const Eigen::Vector3d& left,
                                     const Eigen::Vector3d& right) const {
    const Eigen::Vector3d b = baseline_.cross(right);
    return left.cross(right).dot(b) / b.squaredNorm();
}

}  // namespace divemesh::dive
