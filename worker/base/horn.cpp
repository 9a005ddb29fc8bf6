#include "worker/base/horn.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace divemesh::base {
namespace {

Eigen::Vector3d mean(const std::vector<Eigen::Vector3d>& points) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const auto& point : points) sum += point;
    return sum / static_cast<double>(points.size());
}

// Returns Horn's matrix N. Its eigenvector of the largest eigenvalue is the rotation as a
// quaternion (w x y z).
Eigen::Matrix4d horn_matrix(const Eigen::Matrix3d& S) {
    Eigen::Matrix4d n;
    const Eigen::Vector3d twist(S(1, 2) - S(2, 1), S(2, 0) - S(0, 2), S(0, 1) - S(1, 0));
    n(0, 0) = S.trace();
    n.block<1, 3>(0, 1) = twist.transpose();
    n.block<3, 1>(1, 0) = twist;
    n.block<3, 3>(1, 1) = S + S.transpose() - S.trace() * Eigen::Matrix3d::Identity();
    return n;
}

}  // namespace

std::optional<AbsoluteOrientation> absolute_orientation(const std::vector<Eigen::Vector3d>& a,
                                                        const std::vector<Eigen::Vector3d>& b) {
    if (a.size() < 3 || a.size() != b.size()) return std::nullopt;
    const Eigen::Vector3d mean_a = mean(a);
    const Eigen::Vector3d mean_b = mean(b);
    Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
    double spread_a = 0.0;
    double spread_b = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        products += (a[i] - mean_a) * (b[i] - mean_b).transpose();
        spread_a += (a[i] - mean_a).squaredNorm();
        spread_b += (b[i] - mean_b).squaredNorm();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(horn_matrix(products));
    const Eigen::Vector4d& values = solver.eigenvalues();  // ascending
    // Points on a line do not fix the rotation about it: the two largest eigenvalues are then
    // equal.
    if (!(spread_a > 0.0) || !(spread_b > 0.0) || values(3) - values(2) < 1e-9 * values(3))
        return std::nullopt;
    const Eigen::Vector4d q = solver.eigenvectors().col(3);
    AbsoluteOrientation result;
    result.T_b_a.linear() = Eigen::Quaterniond(q(0), q(1), q(2), q(3)).toRotationMatrix();
    result.T_b_a.translation() = mean_b - result.T_b_a.linear() * mean_a;
    result.scale = std::sqrt(spread_b / spread_a);
    return result;
}

}  // namespace divemesh::base
