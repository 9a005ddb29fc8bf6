#include "worker/odometry/sigma_of_motion.hpp"

#include <cmath>

#include "worker/odometry/refine_pose.hpp"

namespace divemesh::odometry {
namespace {

// A motion over one second that nothing measured errs by these along and about each axis.
constexpr double kPositionSigma_m = 0.1;
constexpr double kRotationSigma_rad = 0.1;

// Variances of consecutive steps add up to the same, whatever the frame rate.
types::MotionSigma sigma_of_unmeasured(const std::optional<types::KnownRotation>& rotation,
                                       double interval_s) {
    const double times = std::sqrt(interval_s);
    return {times * kPositionSigma_m, rotation ? rotation->sigma_rad : times * kRotationSigma_rad};
}

}  // namespace

types::MotionSigma sigma_of_motion(const types::RectifiedRig& rig,
                                   const Registration& vision,
                                   const MotionGuess& motion,
                                   double interval_s) {
    if (!vision.found) return sigma_of_unmeasured(motion.rotation, interval_s);
    const auto covariance = motion_covariance(rig, vision.inliers, motion);
    const double moved_m2 = covariance.bottomRightCorner<3, 3>().trace() / 3.0;
    const double turned_rad2 = covariance.topLeftCorner<3, 3>().trace() / 3.0;
    // Neither holds where the refinement failed: NaN, or not positive.
    if (!(moved_m2 > 0.0 && turned_rad2 > 0.0 && std::isfinite(moved_m2 + turned_rad2)))
        return sigma_of_unmeasured(motion.rotation, interval_s);
    return {std::sqrt(moved_m2), std::sqrt(turned_rad2)};
}

}  // namespace divemesh::odometry
