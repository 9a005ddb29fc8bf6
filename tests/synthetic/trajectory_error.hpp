#pragma once

#include <Eigen/Geometry>
#include <vector>

namespace divemesh::synthetic {

// Returns the mean square distance, m^2, of an estimate from the truth after the best SE(3)
// (Umeyama 1991, by Eigen): the absolute trajectory error squared.
inline double squared_ate_m2(const std::vector<Eigen::Vector3d>& estimate,
                             const std::vector<Eigen::Vector3d>& truth) {
    const auto num = static_cast<Eigen::Index>(truth.size());
    Eigen::Matrix3Xd a(3, num), b(3, num);
    for (Eigen::Index i = 0; i < num; ++i) {
        a.col(i) = estimate[static_cast<std::size_t>(i)];
        b.col(i) = truth[static_cast<std::size_t>(i)];
    }
    const Eigen::Matrix4d T = Eigen::umeyama(a, b, false);
    const Eigen::Matrix3Xd aligned =
        (T.topLeftCorner<3, 3>() * a).colwise() + Eigen::Vector3d(T.topRightCorner<3, 1>());
    return (aligned - b).squaredNorm() / static_cast<double>(num);
}

}  // namespace divemesh::synthetic
