#include "worker/odometry/sigma_of_motion.hpp"

#include <cmath>

#include "worker/odometry/refine_pose.hpp"

namespace divemesh::odometry {
namespace {

// Of a motion that nothing measured, along and about each axis.
constexpr double kSpeedSigma_m_s = 0.1;
constexpr double kTurnSigma_rad_s = 0.1;

}  // namespace

types::MotionSigma sigma_of_motion(const types::RectifiedRig& rig,
                                   const Registration& vision,
                                   const MotionGuess& motion,
                                   double interval_s) {
    if (!vision.found)
        return {kSpeedSigma_m_s * interval_s,
                motion.rotation ? motion.rotation->sigma_rad : kTurnSigma_rad_s * interval_s};
    const auto covariance = motion_covariance(rig, vision.inliers, motion);
    return {std::sqrt(covariance.bottomRightCorner<3, 3>().trace() / 3.0),
            std::sqrt(covariance.topLeftCorner<3, 3>().trace() / 3.0)};
}

}  // namespace divemesh::odometry
