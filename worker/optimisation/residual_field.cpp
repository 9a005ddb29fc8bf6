#include "worker/optimisation/residual_field.hpp"

#include <algorithm>

namespace divemesh::optimisation {
namespace {

// The position of a coordinate between two nodes.
struct BetweenNodes {
    int first = 0;
    double share = 0.0;  // of the next node
};

BetweenNodes between_nodes(double at_px, int size_px, int num_nodes) {
    const double steps = std::clamp(at_px / size_px, 0.0, 1.0) * (num_nodes - 1);
    const int first = std::min(static_cast<int>(steps), num_nodes - 2);
    return {first, steps - first};
}

}  // namespace

Eigen::Matrix<double, 3, kFieldSize> by_field(const types::RectifiedRig& rig,
                                              const Eigen::Vector3d& measured_px) {
    const BetweenNodes u = between_nodes(measured_px.x(), rig.width_px, kFieldColumns);
    const BetweenNodes v = between_nodes(measured_px.y(), rig.height_px, kFieldRows);
    Eigen::Matrix<double, 3, kFieldSize> result = Eigen::Matrix<double, 3, kFieldSize>::Zero();
    for (const int down : {0, 1})
        for (const int right : {0, 1}) {
            const double weight =
                (right == 1 ? u.share : 1.0 - u.share) * (down == 1 ? v.share : 1.0 - v.share);
            const Eigen::Index node = (v.first + down) * kFieldColumns + u.first + right;
            result.block<3, 3>(0, 3 * node) = weight * Eigen::Matrix3d::Identity();
        }
    return result;
}

double field_variance(const ClusteredInformation& information,
                      const Eigen::MatrixXd& moved,
                      Eigen::Index first) {
    const SharedScores& scores = information.of_shared;
    const auto nodes = moved.middleCols<kFieldSize>(first);
    const auto V = information.V_lower.selfadjointView<Eigen::Lower>();
    const Eigen::MatrixXd varied = V * nodes;
    const double noise =
        scores.variances.segment<kFieldSize>(first).sum() -
        2.0 * nodes.cwiseProduct(scores.covariance.middleCols<kFieldSize>(first)).sum() +
        nodes.cwiseProduct(varied).sum();
    const Eigen::MatrixXd M = scores.information.block<kFieldSize, kFieldSize>(first, first) -
                              information.B.middleCols<kFieldSize>(first).transpose() * nodes;
    const double shown = scores.sum.segment<kFieldSize>(first).squaredNorm() - noise;
    return M.squaredNorm() > 0.0 ? std::max(0.0, shown / M.squaredNorm()) : 0.0;
}

}  // namespace divemesh::optimisation
