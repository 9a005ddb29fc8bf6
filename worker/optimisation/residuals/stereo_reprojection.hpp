#pragma once

#include <Eigen/Geometry>
#include <ceres/sized_cost_function.h>

#include "worker/base/rotation_vector.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::optimisation {

// The reprojection error of a landmark in a rectified pair, with the measurement m = (u, v,
// disparity):
//
//     p = T_cam_imu T_imu_world p_world
//     r = (f px/pz + cx - u, f py/pz + cy - v, f b/pz - d) / sigma
//
// The disparity is used instead of the right column: it is measured relative to the left column, so
// their errors are independent. Without disparity the third row is 0. Blocks: q_world_imu (x y z
// w), p_world_imu (m), p_world (m).
struct StereoReprojection {
    types::RectifiedRig rig;
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

    // Returns the residual and its derivative with respect to the landmark; that with respect to
    // the position is the negative. The derivative is that of the formula as computed, so it also
    // holds for a q of not exactly unit length. False if the landmark is not in front of the
    // camera.
    bool linearise(const double* q_world_imu,
                   const double* p_world_imu,
                   const double* p_world,
                   Eigen::Vector3d& residual,
                   Eigen::Matrix3d& jacobian_world) const {
        if (!(*this)(q_world_imu, p_world_imu, p_world, residual.data())) return false;
        const Eigen::Map<const Eigen::Quaterniond> q(q_world_imu);
        const Eigen::Vector3d d = Eigen::Map<const Eigen::Vector3d>(p_world) -
                                  Eigen::Map<const Eigen::Vector3d>(p_world_imu);
        const Eigen::Matrix3d cross = -base::cross_matrix(q.vec());
        jacobian_world = jacobian_of_point(q.conjugate() * d) *
                         (Eigen::Matrix3d::Identity() + 2.0 * q.w() * cross + 2.0 * cross * cross);
        return true;
    }

    Eigen::Matrix3d jacobian_of_point(const Eigen::Vector3d& in_imu) const {
        const Eigen::Matrix3d R_cam_imu = rig.T_imu_cam.linear().transpose();
        const Eigen::Vector3d p = R_cam_imu * (in_imu - rig.T_imu_cam.translation());
        const double scale = rig.focal_px / p.z();
        Eigen::Matrix3d jacobian_cam;
        jacobian_cam << scale / sigma_px.x(), 0.0, -scale * p.x() / p.z() / sigma_px.x(),  //
            0.0, scale / sigma_px.y(), -scale * p.y() / p.z() / sigma_px.y(),              //
            0.0, 0.0, -scale * rig.baseline_m / p.z() / sigma_px.z();
        if (measured_px.z() <= 0.0) jacobian_cam.row(2).setZero();
        return jacobian_cam * R_cam_imu;
    }

    static ceres::CostFunction* create(const StereoReprojection& reprojection);
};

// The same with analytic derivatives, as it takes most of the time of a bundle adjustment. With u =
// -q.vec() and d = p_world - p_world_imu,
//
//     q^-1 d = d + 2 w (u x d) + 2 u x (u x d)
//     d/du   = -2 w [d]x + 2 ((u d) 1 + u d^T - 2 d u^T),   d/dw = 2 (u x d)
class StereoReprojectionCost : public ceres::SizedCostFunction<3, 4, 3, 3> {
public:
    explicit StereoReprojectionCost(const StereoReprojection& reprojection)
        : reprojection_(reprojection) {}

    bool Evaluate(double const* const* blocks, double* r, double** jacobians) const override {
        if (!jacobians) return reprojection_(blocks[0], blocks[1], blocks[2], r);
        Eigen::Vector3d residual;
        Eigen::Matrix3d jacobian_world;
        if (!reprojection_.linearise(blocks[0], blocks[1], blocks[2], residual, jacobian_world))
            return false;
        Eigen::Map<Eigen::Vector3d>{r} = residual;
        if (jacobians[2]) store(jacobian_world, jacobians[2]);
        if (jacobians[1]) store(-jacobian_world, jacobians[1]);
        if (!jacobians[0]) return true;
        const Eigen::Map<const Eigen::Quaterniond> q(blocks[0]);
        const Eigen::Vector3d d = Eigen::Map<const Eigen::Vector3d>(blocks[2]) -
                                  Eigen::Map<const Eigen::Vector3d>(blocks[1]);
        const Eigen::Matrix3d jacobian_imu = reprojection_.jacobian_of_point(q.conjugate() * d);
        const Eigen::Vector3d u = -q.vec();
        Eigen::Map<Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> jacobian_q(jacobians[0]);
        jacobian_q.leftCols<3>() =
            jacobian_imu * (2.0 * q.w() * base::cross_matrix(d) -
                            2.0 * (u.dot(d) * Eigen::Matrix3d::Identity() + u * d.transpose() -
                                   2.0 * d * u.transpose()));
        jacobian_q.col(3) = jacobian_imu * (2.0 * u.cross(d));
        return true;
    }

private:
    static void store(const Eigen::Matrix3d& jacobian, double* to) {
        Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>{to} = jacobian;
    }

    const StereoReprojection reprojection_;
};

inline ceres::CostFunction* StereoReprojection::create(const StereoReprojection& reprojection) {
    return new StereoReprojectionCost(reprojection);
}

}  // namespace divemesh::optimisation
