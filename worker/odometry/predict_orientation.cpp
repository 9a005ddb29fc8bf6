#include "worker/odometry/predict_orientation.hpp"

namespace divemesh::odometry {
namespace {

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

MotionGuess predict_orientation(const std::optional<types::KnownRotation>& q_current_previous,
                                const Registration& motion) {
    MotionGuess guess;
    guess.T_current_previous = motion.T_current_previous;
    if (!q_current_previous) return guess;
    guess.rotation = q_current_previous;
    guess.T_current_previous.linear() = q_current_previous->q.toRotationMatrix();
    if (!motion.found) return guess;
    guess.disagreement_rad = q_current_previous->q.angularDistance(
        Eigen::Quaterniond(motion.T_current_previous.linear()));
    guess.T_current_previous.translation() =
        translation_for(guess.T_current_previous.linear(), motion.inliers);
    return guess;
}

}  // namespace divemesh::odometry
