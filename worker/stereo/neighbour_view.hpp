#pragma once

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "worker/types/rectified_rig.hpp"

namespace divemesh::stereo {

// Another frame that shows the same scene.
struct NeighbourView {
    cv::Mat left;                   // CV_8UC1, rectified, of the same rig
    Eigen::Isometry3d T_other_cam;  // from the camera of the depth map to this one
};

// Maps a pixel (u, v) with the disparity d to a neighbour: in homogeneous coordinates
// M (u, v, 1) + m d.
struct ViewProjection {
    ViewProjection(const types::RectifiedRig& rig, const Eigen::Isometry3d& T_other_cam) {
        Eigen::Matrix3d K;
        K << rig.focal_px, 0.0, rig.cx_px, 0.0, rig.focal_px, rig.cy_px, 0.0, 0.0, 1.0;
        M = (K * T_other_cam.linear() * K.inverse()).cast<float>();
        m = (K * T_other_cam.translation() / (rig.focal_px * rig.baseline_m)).cast<float>();
    }

    Eigen::Matrix3f M;
    Eigen::Vector3f m;
};

}  // namespace divemesh::stereo
