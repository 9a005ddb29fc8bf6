#include "worker/evaluation/alignment.hpp"

#include <Eigen/SVD>

namespace divemesh::evaluation {
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

// Returns the rotation nearest to a sum of products reference * world^T.
Eigen::Matrix3d nearest_rotation(const Svd& svd) {
    Eigen::Vector3d signs = Eigen::Vector3d::Ones();
    if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) signs.z() = -1.0;
    return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

// Sums over the positions relative to their centres.
struct Scatter {
    Eigen::Matrix3d products = Eigen::Matrix3d::Zero();  // reference * world^T
    double world_variance = 0.0;
};

Scatter scatter_of(const std::vector<PosePair>& pairs, const Centres& centres) {
    Scatter scatter;
    for (const PosePair& pair : pairs) {
        const Eigen::Vector3d reference = pair.T_reference_body.translation() - centres.reference;
        const Eigen::Vector3d world = pair.T_world_body.translation() - centres.world;
        scatter.products += reference * world.transpose();
        scatter.world_variance += world.squaredNorm();
    }
    return scatter;
}

Eigen::Isometry3d about_centres(const Eigen::Matrix3d& R, const Centres& centres) {
    Eigen::Isometry3d T_reference_world = Eigen::Isometry3d::Identity();
    T_reference_world.linear() = R;
    T_reference_world.translation() = centres.reference - R * centres.world;
    return T_reference_world;
}

constexpr int kDecompose = Eigen::ComputeFullU | Eigen::ComputeFullV;

}  // namespace

Alignment align(const std::vector<PosePair>& pairs) {
    constexpr double kLineRatio = 1e-4;  // squared ratio of the extents across and along: 1 in 100
    const Centres centres = centres_of(pairs);
    const Scatter scatter = scatter_of(pairs, centres);
    Svd svd(scatter.products, kDecompose);
    const Eigen::Vector3d extents = svd.singularValues();
    if (extents[1] <= kLineRatio * extents[0])
        svd.compute(scatter.products + rotation_part(pairs), kDecompose);
    const Eigen::Matrix3d R = nearest_rotation(svd);
    Alignment alignment;
    alignment.T_reference_world = about_centres(R, centres);
    if (scatter.world_variance > 0.0)
        alignment.sim3_scale = (R.transpose() * scatter.products).trace() / scatter.world_variance;
    return alignment;
}

Eigen::Isometry3d align_poses(const std::vector<PosePair>& pairs) {
    const Centres centres = centres_of(pairs);
    const Svd svd(scatter_of(pairs, centres).products + rotation_part(pairs), kDecompose);
    return about_centres(nearest_rotation(svd), centres);
}

std::vector<Eigen::Vector3d> scaled_about_centre(const std::vector<PosePair>& pairs,
                                                 const Alignment& alignment) {
    const Centres centres = centres_of(pairs);
    std::vector<Eigen::Vector3d> positions;
    positions.reserve(pairs.size());
    for (const PosePair& pair : pairs)
        positions.emplace_back(alignment.sim3_scale *
                                   (alignment.T_reference_world.linear() *
                                    (pair.T_world_body.translation() - centres.world)) +
                               centres.reference);
    return positions;
}

}  // namespace divemesh::evaluation
