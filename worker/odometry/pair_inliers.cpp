#include "worker/odometry/pair_inliers.hpp"

#include <algorithm>

namespace divemesh::odometry {
namespace {

double squared_error_px(const types::RectifiedRig& rig,
                        const PointPair& pair,
                        const Eigen::Isometry3d& T_current_previous) {
    const Eigen::Vector3d p_current = T_current_previous * pair.p_previous;
    if (p_current.z() < 1e-3) return 1e9;
    return (types::project_px(rig, p_current) - pair.current_px).squaredNorm();
}

}  // namespace

PointPairs find_inliers(const types::RectifiedRig& rig,
                        const PointPairs& pairs,
                        const Eigen::Isometry3d& T_current_previous,
                        double tolerance_px) {
    PointPairs result;
    for (const PointPair& pair : pairs)
        if (squared_error_px(rig, pair, T_current_previous) < tolerance_px * tolerance_px)
            result.push_back(pair);
    return result;
}

double msac_cost(const types::RectifiedRig& rig,
                 const PointPairs& pairs,
                 const Eigen::Isometry3d& T_current_previous,
                 double tolerance_px) {
    double sum = 0.0;
    const double max_squared_px = tolerance_px * tolerance_px;
    for (const PointPair& pair : pairs)
        sum += std::min(max_squared_px, squared_error_px(rig, pair, T_current_previous));
    return sum;
}

}  // namespace divemesh::odometry
