#include "worker/metrics/alignment.hpp"

#include <Eigen/SVD>

namespace divemesh::worker {
namespace {

using Svd = Eigen::JacobiSVD<Eigen::Matrix3d>;

struct Centres {
    Eigen::Vector3d reference = Eigen::Vector3d::Zero();
    Eigen::Vector3d world = Eigen::Vector3d::Zero();
};

Centres centres_of(const std::vector<PosePair>& pairs) {
    Centres centres;
    for (const PosePair& pair : pairs) {
        centres.reference += pair.T_reference_body.translation();
        centres.world += pair.T_world_body.translation();
    }
    centres.reference /= static_cast<double>(pairs.size());
    centres.world /= static_cast<double>(pairs.size());
    return centres;
}

Eigen::Matrix3d rotation_part(const std::vector<PosePair>& pairs) {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (const PosePair& pair : pairs)
        sum += pair.T_reference_body.linear() * pair.T_world_body.linear().transpose();
    return sum;
}

// The rotation nearest to a sum of products reference * world^T.
Eigen::Matrix3d nearest_rotation(const Svd& svd) {
    Eigen::Vector3d signs = Eigen::Vector3d::Ones();
    if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) signs.z() = -1.0;
    return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

}  // namespace

Alignment align(const std::vector<PosePair>& pairs) {
    constexpr double kLineRatio = 1e-4;  // squared extents across and along: 1 in 100
    constexpr int kDecompose = Eigen::ComputeFullU | Eigen::ComputeFullV;
    const Centres centres = centres_of(pairs);
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    double world_variance = 0.0;
    for (const PosePair& pair : pairs) {
        const Eigen::Vector3d reference = pair.T_reference_body.translation() - centres.reference;
        const Eigen::Vector3d world = pair.T_world_body.translation() - centres.world;
        covariance += reference * world.transpose();
        world_variance += world.squaredNorm();
    }
    Svd svd(covariance, kDecompose);
    const Eigen::Vector3d extents = svd.singularValues();
    if (extents[1] <= kLineRatio * extents[0])
        svd.compute(covariance + rotation_part(pairs), kDecompose);
    const Eigen::Matrix3d R = nearest_rotation(svd);
    Alignment alignment;
    alignment.T_reference_world.linear() = R;
    alignment.T_reference_world.translation() = centres.reference - R * centres.world;
    if (world_variance > 0.0)
        alignment.sim3_scale = (R.transpose() * covariance).trace() / world_variance;
    return alignment;
}

std::vector<Eigen::Vector3d> scaled_about_centre(const std::vector<PosePair>& pairs,
                                                 const Alignment& alignment) {
    const Centres centres = centres_of(pairs);
    std::vector<Eigen::Vector3d> positions;
    for (const PosePair& pair : pairs)
        positions.emplace_back(alignment.sim3_scale *
                                   (alignment.T_reference_world.linear() *
                                    (pair.T_world_body.translation() - centres.world)) +
                               centres.reference);
    return positions;
}

}  // namespace divemesh::worker
