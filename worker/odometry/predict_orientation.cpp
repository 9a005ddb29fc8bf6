#include "worker/odometry/predict_orientation.hpp"

#include <Eigen/Cholesky>

#include "worker/base/rotation_vector.hpp"
#include "worker/odometry/refine_pose.hpp"
#include "worker/stats/ratio.hpp"

namespace divemesh::odometry {
namespace {

// Vision contradicts a gyroscope when most pairs agree with a rotation that many sigmas of both do
// not explain. Clocks and axes that are hardly known explain less than that between two frames.
constexpr std::size_t kMinInliersToContradict = 30;
constexpr double kMinShareToContradict = 0.7;  // of the pairs
constexpr double kMaxSigmas = 10.0;

bool contradicts(const types::RectifiedRig& rig,
                 const Registration& motion,
                 const types::KnownRotation& known) {
    const std::size_t num = motion.inliers.size();
    if (num < kMinInliersToContradict ||
        stats::ratio(num, motion.num_pairs) < kMinShareToContradict)
        return false;
    const RefinedPose seen = refine_pose(rig, motion.inliers, {motion.T_current_previous, {}, {}});
    if (seen.outcome.failed()) return false;
    const Eigen::Vector3d error = base::vector_from_rotation(
        Eigen::Quaterniond(seen.T_current_previous.linear()) * known.q.conjugate());
    Eigen::Matrix3d covariance =
        motion_covariance(rig, motion.inliers, {seen.T_current_previous, {}, {}})
            .topLeftCorner<3, 3>();
    covariance.diagonal().array() += known.sigma_rad * known.sigma_rad;
    return error.dot(covariance.ldlt().solve(error)) > kMaxSigmas * kMaxSigmas;
}

// Returns the best translation of the inliers for a given rotation. Near points measure it best:
// the weight is disparity squared, as the depth error is proportional to 1 / disparity^2.
Eigen::Vector3d translation_for(const Eigen::Matrix3d& R, const PointPairs& inliers) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double weights = 0.0;
    for (const PointPair& pair : inliers) {
        const double weight = pair.current_px.z() * pair.current_px.z();
        sum += weight * (pair.p_current - R * pair.p_previous);
        weights += weight;
    }
    return sum / weights;
}

}  // namespace

MotionGuess predict_orientation(const types::RectifiedRig& rig,
                                const std::optional<types::KnownRotation>& q_current_previous,
                                const Registration& motion) {
    MotionGuess guess;
    guess.T_current_previous = motion.T_current_previous;
    if (!q_current_previous) return guess;
    if (motion.found)
        guess.disagreement_rad = q_current_previous->q.angularDistance(
            Eigen::Quaterniond(motion.T_current_previous.linear()));
    if (motion.found && contradicts(rig, motion, *q_current_previous)) return guess;
    guess.rotation = q_current_previous;
    guess.T_current_previous.linear() = q_current_previous->q.toRotationMatrix();
    if (motion.found)
        guess.T_current_previous.translation() =
            translation_for(guess.T_current_previous.linear(), motion.inliers);
    return guess;
}

}  // namespace divemesh::odometry
