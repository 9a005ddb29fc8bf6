#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <ceres/autodiff_cost_function.h>
#include <ceres/rotation.h>

#include "worker/types/rectified_rig.hpp"

namespace divemesh::optimisation {

// A point measured by the stereo camera at both times, m = (u, v, disparity). The point of t-1 is
// moved, projected and compared with the measurement at t:
//
//     e = h(R p(m_a) + T) - m_b         p: triangulation, h: projection
//     r = L^-1 e,   L L^T = S_b + J S_a J^T,   J = d h(R p(m) + T) / d m at m_a
//
// Both measurements are noisy, the depths of far points most. Weighting by the whole covariance,
// which changes with (R, T), keeps that noise from shrinking the motion (errors in variables;
// Matthies and Shafer, "Error modeling in stereo navigation", 1987).
struct PointTransfer {
    types::RectifiedRig rig;
    Eigen::Vector3d previous_px;
    Eigen::Vector3d current_px;
    Eigen::Vector3d previous_sigma_px;  // of u, v, disparity
    Eigen::Vector3d current_sigma_px;

    template <typename T>
    bool operator()(const T* const rodrigues, const T* const translation, T* residual) const {
        const double f = rig.focal_px;
        const double fb = f * rig.baseline_m;
        const double d = previous_px.z();
        const Eigen::Vector3d p = rig.point_cam(previous_px.x(), previous_px.y(), fb / d);
        T R_data[9];
        ceres::AngleAxisToRotationMatrix(rodrigues, R_data);  // column-major
        const Eigen::Map<const Eigen::Matrix<T, 3, 3>> R(R_data);
        const Eigen::Map<const Eigen::Matrix<T, 3, 1>> t(translation);
        const Eigen::Matrix<T, 3, 1> moved = R * p.cast<T>() + t;
        if (moved.z() < T(1e-3)) return false;

        const T inverse_z = T(1.0) / moved.z();
        Eigen::Matrix<T, 3, 3> project;  // d h / d moved
        project << T(f) * inverse_z, T(0.0), -T(f) * moved.x() * inverse_z * inverse_z, T(0.0),
            T(f) * inverse_z, -T(f) * moved.y() * inverse_z * inverse_z, T(0.0), T(0.0),
            -T(fb) * inverse_z * inverse_z;
        Eigen::Matrix3d triangulate;  // d p / d m
        triangulate << p.z() / f, 0.0, -p.x() / d, 0.0, p.z() / f, -p.y() / d, 0.0, 0.0, -p.z() / d;
        const Eigen::Matrix<T, 3, 3> J = project * R * triangulate.cast<T>();
        const Eigen::Matrix<T, 3, 3> S_a = variances(previous_sigma_px).template cast<T>();
        const Eigen::Matrix<T, 3, 3> S_b = variances(current_sigma_px).template cast<T>();
        const Eigen::Matrix<T, 3, 3> covariance = S_b + J * S_a * J.transpose();

        Eigen::Map<Eigen::Matrix<T, 3, 1>> r(residual);
        r << T(f) * moved.x() * inverse_z + T(rig.cx_px - current_px.x()),
            T(f) * moved.y() * inverse_z + T(rig.cy_px - current_px.y()),
            T(fb) * inverse_z - T(current_px.z());
        const Eigen::LLT<Eigen::Matrix<T, 3, 3>> factor(covariance);
        factor.matrixL().solveInPlace(r);
        return true;
    }

    static Eigen::Matrix3d variances(const Eigen::Vector3d& sigma) {
        return sigma.cwiseAbs2().asDiagonal();
    }

    static ceres::CostFunction* create(const PointTransfer& transfer) {
        return new ceres::AutoDiffCostFunction<PointTransfer, 3, 3, 3>(new PointTransfer(transfer));
    }
};

}  // namespace divemesh::optimisation
