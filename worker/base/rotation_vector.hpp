#pragma once

#include <Eigen/Geometry>

namespace divemesh::base {

// Returns the rotation by |w| about w, rad (Rodrigues).
inline Eigen::Quaterniond rotation_from_vector(const Eigen::Vector3d& w) {
    const double angle = w.norm();
    if (angle < 1e-12)
        return Eigen::Quaterniond(1.0, 0.5 * w.x(), 0.5 * w.y(), 0.5 * w.z()).normalized();
    return Eigen::Quaterniond(Eigen::AngleAxisd(angle, w / angle));
}

// Returns the rotation vector of q, |w| <= pi.
inline Eigen::Vector3d vector_from_rotation(const Eigen::Quaterniond& q) {
    const Eigen::AngleAxisd rotation(q.w() < 0.0 ? Eigen::Quaterniond(-q.coeffs()) : q);
    return rotation.angle() * rotation.axis();
}

// The same for small rotations, as residuals use it: the vector is twice the vector part of the
// quaternion. The relative error is 1e-4 below 3 degrees, and it is differentiable at 0.
template <typename T>
Eigen::Quaternion<T> rotation_from_small_vector(const Eigen::Matrix<T, 3, 1>& w) {
    return Eigen::Quaternion<T>(T(1.0), T(0.5) * w.x(), T(0.5) * w.y(), T(0.5) * w.z())
        .normalized();
}

template <typename T>
Eigen::Matrix<T, 3, 1> vector_from_small_rotation(const Eigen::Quaternion<T>& q) {
    return (q.w() < T(0.0) ? T(-2.0) : T(2.0)) * q.vec();
}

// Returns the angle of a rotation, rad, 0 to pi.
inline double angle_rad(const Eigen::Matrix3d& R) { return Eigen::AngleAxisd(R).angle(); }

// Returns the matrix M with M a = v x a (cross product).
inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
    Eigen::Matrix3d m;
    m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
    return m;
}

// Returns the right Jacobian J of SO(3): exp(w + dw) = exp(w) exp(J dw).
inline Eigen::Matrix3d right_jacobian(const Eigen::Vector3d& w) {
    const double angle = w.norm();
    const Eigen::Matrix3d cross = cross_matrix(w);
    if (angle < 1e-5) return Eigen::Matrix3d::Identity() - 0.5 * cross;
    const double squared = angle * angle;
    return Eigen::Matrix3d::Identity() - (1.0 - std::cos(angle)) / squared * cross +
           (angle - std::sin(angle)) / (squared * angle) * cross * cross;
}

}  // namespace divemesh::base
