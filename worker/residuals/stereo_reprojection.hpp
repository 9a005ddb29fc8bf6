#pragma once

#include <Eigen/Geometry>
#include <ceres/autodiff_cost_function.h>

#include "worker/geometry/rectified_rig.hpp"

namespace divemesh::worker {

// A landmark against what the rectified pair measured of it, m = (u, v, disparity):
//
//     p = T_cam_imu T_imu_world p_world
//     r = (f px/pz + cx - u, f py/pz + cy - v, f b/pz - d) / sigma
//
// Disparity, not the right column: it is measured from the left one, so their errors are
// independent. Without disparity the third row is 0. Blocks: q_world_imu (x y z w), p_world_imu
// (m), p_world (m).
struct StereoReprojection {
    RectifiedRig rig;
    Eigen::Vector3d measured_px;
    Eigen::Vector3d sigma_px;

    template <typename T>
    bool operator()(const T* const q_world_imu,
                    const T* const p_world_imu,
                    const T* const p_world,
                    T* residual) const {
        const Eigen::Map<const Eigen::Quaternion<T>> q(q_world_imu);
        const Eigen::Map<const Eigen::Matrix<T, 3, 1>> imu(p_world_imu);
        const Eigen::Map<const Eigen::Matrix<T, 3, 1>> point(p_world);
        const Eigen::Matrix<T, 3, 1> in_imu = q.conjugate() * (point - imu);
        const Eigen::Matrix<T, 3, 1> p = rig.T_imu_cam.linear().transpose().cast<T>() *
                                         (in_imu - rig.T_imu_cam.translation().cast<T>());
        if (p.z() < T(0.02)) return false;
        const T scale = T(rig.focal_px) / p.z();
        residual[0] = (scale * p.x() + T(rig.cx_px - measured_px.x())) / T(sigma_px.x());
        residual[1] = (scale * p.y() + T(rig.cy_px - measured_px.y())) / T(sigma_px.y());
        residual[2] = measured_px.z() > 0.0
                          ? (scale * T(rig.baseline_m) - T(measured_px.z())) / T(sigma_px.z())
                          : T(0.0);
        return true;
    }

    static ceres::CostFunction* create(const StereoReprojection& reprojection) {
        return new ceres::AutoDiffCostFunction<StereoReprojection, 3, 4, 3, 3>(
            new StereoReprojection(reprojection));
    }
};

}  // namespace divemesh::worker
