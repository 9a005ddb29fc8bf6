#include "worker/base/nearest_to_rays.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace divemesh::base {

std::optional<Eigen::Vector3d> nearest_to_rays(const std::vector<Ray>& rays, double min_parallax) {
    if (rays.empty()) return std::nullopt;
    Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    for (const Ray& ray : rays) {
        const Eigen::Vector3d along = ray.direction.normalized();
        const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - along * along.transpose();
        A += across;
        b += across * ray.origin;
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(A);
    if (solver.eigenvalues()[0] < min_parallax * static_cast<double>(rays.size()))
        return std::nullopt;
    return A.ldlt().solve(b);
}

}  // namespace divemesh::base
