#pragma once

#include <Eigen/Geometry>
#include <opencv2/core/types.hpp>

#include "worker/types/rig.hpp"

namespace divemesh::dive {

// The rays of both cameras through pixels of the images as recorded, in the frame of cam0.
class StereoRays {
public:
    explicit StereoRays(const types::Rig& rig);

    Eigen::Vector3d left(const cv::Point2f& pixel) const;  // z = 1
    Eigen::Vector3d right(const cv::Point2f& pixel) const;

    // Returns the signed angle between the right ray and the epipolar plane of the left ray, as
    // pixels of the left camera.
    double epipolar_error_px(const Eigen::Vector3d& left, const Eigen::Vector3d& right) const;
    // Returns the inverse depth along the left ray where the right ray comes nearest to it;
    // negative if the rays meet behind the cameras.
    double inverse_depth_1_m(const Eigen::Vector3d& left, const Eigen::Vector3d& right) const;
    Eigen::Vector2d baseline_direction() const { return baseline_.head<2>().normalized(); }

private:
    types::Rig rig_;
    Eigen::Isometry3d T_cam0_cam1_;
    Eigen::Vector3d baseline_;  // m, in cam0
};

}  // namespace divemesh::dive
