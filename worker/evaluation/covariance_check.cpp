#include "worker/evaluation/covariance_check.hpp"

#include <Eigen/Cholesky>

#include "worker/evaluation/trajectory_pairs.hpp"
#include "worker/stats/distributions.hpp"

namespace divemesh::evaluation {

std::optional<CovarianceCheck> check_covariances(const types::Trajectory& estimate,
                                                 const types::CovarianceTrack& covariances,
                                                 const types::Trajectory& reference) {
    if (covariances.size() != estimate.size() || estimate.empty()) return std::nullopt;
    const auto first = pose_at(reference, estimate.front().timestamp_ns);
    if (!first) return std::nullopt;
    const double bound_95 = stats::chi_square_quantile(0.95, 3.0);
    CovarianceCheck check;
    for (std::size_t i = 0; i < estimate.size(); ++i) {
        const auto truth = pose_at(reference, estimate[i].timestamp_ns);
        const Eigen::LDLT<Eigen::Matrix3d> factor(covariances[i].position_m2);
        if (!truth || factor.vectorD().minCoeff() <= 0.0) continue;
        const Eigen::Vector3d error =
            (estimate.front().T_world_imu.inverse() * estimate[i].T_world_imu).translation() -
            (first->inverse() * *truth).translation();
        const double nees = error.dot(factor.solve(error));
        ++check.num_poses;
        check.mean_nees += nees;
        check.share_in_95 += nees <= bound_95 ? 1.0 : 0.0;
    }
    if (check.num_poses == 0) return std::nullopt;
    check.mean_nees /= static_cast<double>(check.num_poses);
    check.share_in_95 /= static_cast<double>(check.num_poses);
    return check;
}

nlohmann::json to_metrics(const CovarianceCheck& check) {
    return {{"num_poses", check.num_poses},
            {"mean_nees", check.mean_nees},
            {"share_in_95", check.share_in_95}};
}

}  // namespace divemesh::evaluation
