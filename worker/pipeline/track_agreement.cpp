#include "worker/pipeline/track_agreement.hpp"

#include <algorithm>
#include <cmath>

#include "worker/base/rotation_vector.hpp"
#include "worker/optimisation/covariance_between.hpp"
#include "worker/optimisation/follow_keyframes.hpp"

namespace divemesh::pipeline {
namespace {

// Limit of an observation's error, and its error if the landmark is behind the camera: a few
// outliers must not decide.
constexpr double kMaxError_px = 10.0;
constexpr double kMinDepth_m = 0.02;
// With another model (loops, calibration) each observation may fit slightly less well, because the
// sliding window fitted the landmarks to its own observations alone.
constexpr double kWorseReprojection = 1.5;
// Twice the noise of a feature's u and v together. Below it, the fit is good whatever it was
// before.
constexpr double kGoodReprojection_px = 0.7;
// For the motions between neighbouring keyframes against the odometry. The drift is 1 % of the
// distance and at least 2 cm, and neighbours differ by far less; three times the drift in the RMS
// means another path.
constexpr double kMaxOdometry_sigmas = 3.0;
// Loops are accepted within 3.5 sigma of the drift; three times that distance cannot be a
// correction of the drift.
constexpr double kMaxMoved_sigmas = 10.0;

double squared_error_px2(const types::RectifiedRig& rig,
                         const types::Keyframe& keyframe,
                         const types::Landmark& landmark,
                         const types::LandmarkObservation& seen) {
    constexpr double kMaxError_px2 = kMaxError_px * kMaxError_px;
    const Eigen::Vector3d p_cam = keyframe.T_world_cam.inverse() * landmark.p_world;
    if (!(p_cam.z() > kMinDepth_m)) return kMaxError_px2;
    const double squared = (rig.pixel(p_cam) - Eigen::Vector2d(seen.u_px, seen.v_px)).squaredNorm();
    return squared < kMaxError_px2 ? squared : kMaxError_px2;
}

double reprojection_rms_px(const types::Track& now,
                           const types::Track& tracked,
                           std::size_t stride) {
    double squares_px2 = 0.0;
    std::size_t num = 0;
    for (std::size_t i = 0; i < tracked.landmarks.size(); i += stride) {
        const types::Landmark& landmark = now.landmarks[i];
        for (std::size_t j = 0; j < tracked.landmarks[i].observations.size(); ++j) {
            const types::LandmarkObservation& seen = landmark.observations[j];
            const auto& keyframe = now.keyframes[static_cast<std::size_t>(seen.keyframe)];
            squares_px2 += squared_error_px2(now.rig, keyframe, landmark, seen);
            ++num;
        }
    }
    return num > 0 ? std::sqrt(squares_px2 / static_cast<double>(num)) : 0.0;
}

double odometry_rms_sigmas(const types::Track& now, const loops::DriftModel& drift) {
    const Eigen::Isometry3d& T_imu_cam = now.rig.T_imu_cam;
    const auto odometry_at = [&](std::size_t k) {
        return now.odometry[optimisation::frame_at(now.odometry, now.keyframes[k].timestamp_ns)]
                   .T_world_imu *
               T_imu_cam;
    };
    double squares = 0.0;
    std::size_t num = 0;
    for (std::size_t k = 1; k < now.keyframes.size(); ++k) {
        if (!drift.follows(k)) continue;
        const Eigen::Isometry3d expected = odometry_at(k - 1).inverse() * odometry_at(k);
        const Eigen::Isometry3d step =
            now.keyframes[k - 1].T_world_cam.inverse() * now.keyframes[k].T_world_cam;
        const double moved =
            (step.translation() - expected.translation()).norm() / drift.position_sigma_m(k - 1, k);
        const double turned = base::angle_rad(step.linear().transpose() * expected.linear()) /
                              drift.orientation_sigma_rad(k - 1, k);
        squares += moved * moved + turned * turned;
        ++num;
    }
    return num > 0 ? std::sqrt(squares / static_cast<double>(num)) : 0.0;
}

bool is_finite(const types::Track& track) {
    return std::all_of(track.keyframes.begin(),
                       track.keyframes.end(),
                       [](const types::Keyframe& keyframe) {
                           return keyframe.T_world_cam.matrix().allFinite();
                       }) &&
           std::all_of(
               track.landmarks.begin(), track.landmarks.end(), [](const types::Landmark& landmark) {
                   return landmark.p_world.allFinite();
               });
}

}  // namespace

types::TrackAgreement agreement(const types::Track& now,
                                const types::Track& tracked,
                                std::size_t landmark_stride,
                                const loops::DriftModel& drift) {
    return {is_finite(now),
            reprojection_rms_px(now, tracked, landmark_stride),
            odometry_rms_sigmas(now, drift)};
}

double moved_rms_sigmas(const std::vector<types::Keyframe>& before,
                        const std::vector<types::Keyframe>& after,
                        const types::CovarianceTrack& covariances,
                        const loops::DriftModel& drift) {
    const auto from_first = [](const std::vector<types::Keyframe>& keyframes, std::size_t k) {
        return Eigen::Vector3d(keyframes.front().T_world_cam.inverse() *
                               keyframes[k].T_world_cam.translation());
    };
    double squares = 0.0;
    std::size_t num = 0;
    for (std::size_t k = 1; k < after.size(); ++k) {
        if (after[k].segment != after.front().segment) continue;
        double variance_m2 = std::pow(drift.position_sigma_m(0, k), 2);
        if (!covariances.empty())
            variance_m2 += optimisation::covariance_between(covariances, after[k].timestamp_ns)
                               .position_m2.trace();
        squares += (from_first(after, k) - from_first(before, k)).squaredNorm() / variance_m2;
        ++num;
    }
    return num > 0 ? std::sqrt(squares / static_cast<double>(num)) : 0.0;
}

// Both checks are written so that NaN counts as worse.
bool contradicts_odometry(const types::TrackCheck& check) {
    return !(check.after.finite &&
             check.after.odometry_rms_sigmas <=
                 std::max(kMaxOdometry_sigmas, check.before.odometry_rms_sigmas));
}

bool is_worse(const types::TrackCheck& check) {
    return contradicts_odometry(check) ||
           !(check.after.reprojection_rms_px <=
             std::max(kGoodReprojection_px,
                      kWorseReprojection * check.before.reprojection_rms_px)) ||
           !(check.moved_rms_sigmas <= kMaxMoved_sigmas);
}

}  // namespace divemesh::pipeline
