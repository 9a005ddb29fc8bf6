#include "worker/loops/drift_model.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "worker/base/rotation_vector.hpp"
#include "worker/base/seconds.hpp"

namespace divemesh::loops {
namespace {

constexpr double kShareOfPath = 0.01;
constexpr double kMinPosition_m = 0.02;
constexpr double kGapSpeed_m_s = 0.3;  // change of a diver's velocity while the scene is lost
// Uncertainty of the inertial prediction when the scene is lost: velocity, acceleration (of the
// bias, and of gravity by a vertical that is off by 0.2 degrees) and angular rate, as the sliding
// window knows them.
constexpr double kVelocitySigma_m_s = 0.01;
constexpr double kAccelerationSigma_m_s2 = 0.03;
constexpr double kRateSigma_rad_s = 5e-4;
// A track with the scene in sight drifts as far in 25 m.
constexpr double kBridgedSigma_m = 0.25;
constexpr double kBridged_s = 1.0;
constexpr double kMinOrientation_rad = 0.01;
constexpr double kRotationDrift_rad_per_m = 0.002;
constexpr double kGapRotationRate_rad_s = 0.05;
constexpr double kNumSigmas = 3.5;
constexpr int kMinSharedLandmarks = 6;  // landmarks that connect a keyframe to earlier ones

double distance_m(const types::Keyframe& a, const types::Keyframe& b) {
    return (a.T_world_cam.translation() - b.T_world_cam.translation()).norm();
}

}  // namespace

DriftModel::DriftModel(const std::vector<types::Keyframe>& keyframes,
                       const std::vector<types::Landmark>& landmarks,
                       const imu::InertialPrior* inertial,
                       const MotionsInSight& in_sight)
    : path_m_(keyframes.size(), 0.0),
      tracking_gaps_(keyframes.size()),
      segment_(keyframes.size(), 0),
      follows_(keyframes.size(), true),
      by_frames_alone_(keyframes.size()),
      first_covisible_(keyframes.size()) {
    std::iota(first_covisible_.begin(), first_covisible_.end(), std::size_t{0});
    // Landmarks observed both before and after a keyframe.
    std::vector<int> num_passing(keyframes.size() + 1, 0);
    for (const types::Landmark& landmark : landmarks) {
        const auto [first, last] = std::minmax_element(
            landmark.observations.begin(),
            landmark.observations.end(),
            [](const auto& a, const auto& b) { return a.keyframe < b.keyframe; });
        const auto from = static_cast<std::size_t>(first->keyframe);
        ++num_passing[from + 1];
        --num_passing[static_cast<std::size_t>(last->keyframe) + 1];
        for (const types::LandmarkObservation& seen : landmark.observations) {
            std::size_t& tied = first_covisible_[static_cast<std::size_t>(seen.keyframe)];
            tied = std::min(tied, from);
        }
    }
    std::partial_sum(num_passing.begin(), num_passing.end(), num_passing.begin());
    std::size_t begin = 0;  // of the keyframes that landmarks connect
    for (std::size_t k = 1; k < keyframes.size(); ++k) {
        path_m_[k] = path_m_[k - 1] + distance_m(keyframes[k - 1], keyframes[k]);
        tracking_gaps_[k] = tracking_gaps_[k - 1];
        segment_[k] = segment_[k - 1];
        const bool connected = num_passing[k] >= kMinSharedLandmarks;
        if (!connected) begin = k;
        first_covisible_[k] = std::max(first_covisible_[k], begin);
        if (connected) continue;
        if (!in_sight.empty() && in_sight[k]) {
            by_frames_alone_[k] = in_sight[k];
            tracking_gaps_[k].position_m += in_sight[k]->position_m;
            tracking_gaps_[k].rotation_rad += in_sight[k]->rotation_rad;
            continue;
        }
        const std::int64_t from_ns = keyframes[k - 1].timestamp_ns;
        const std::int64_t to_ns = keyframes[k].timestamp_ns;
        const TrackingGap added = tracking_gap(inertial, from_ns, to_ns);
        tracking_gaps_[k].position_m += added.position_m;
        tracking_gaps_[k].rotation_rad += added.rotation_rad;
        ++segment_[k];
        follows_[k] =
            base::to_s(to_ns - from_ns) <= kBridged_s || added.position_m <= kBridgedSigma_m;
    }
    for (std::size_t k = keyframes.size(); k-- > 0;)
        first_covisible_[k] = first_covisible_[first_covisible_[k]];
}

DriftModel::TrackingGap DriftModel::tracking_gap(const imu::InertialPrior* inertial,
                                                 std::int64_t from_ns,
                                                 std::int64_t to_ns) {
    const double t_s = base::to_s(to_ns - from_ns);
    TrackingGap result{kGapSpeed_m_s * t_s, kGapRotationRate_rad_s * t_s};
    if (!inertial) return result;
    if (const auto rotation = inertial->integral(from_ns, to_ns))
        result.rotation_rad = std::hypot(rotation->sigma_rad, kRateSigma_rad_s * t_s);
    if (const auto motion = inertial->motion(from_ns, to_ns))
        result.position_m =
            std::sqrt(motion->covariance.bottomRightCorner<3, 3>().diagonal().maxCoeff() +
                      std::pow(kVelocitySigma_m_s * t_s, 2) +
                      std::pow(0.5 * kAccelerationSigma_m_s2 * t_s * t_s, 2));
    return result;
}

double DriftModel::position_sigma_m(std::size_t a, std::size_t b) const {
    return std::hypot(kMinPosition_m, kShareOfPath * std::abs(path_m_[b] - path_m_[a])) +
           std::abs(tracking_gaps_[b].position_m - tracking_gaps_[a].position_m);
}

double DriftModel::orientation_sigma_rad(std::size_t a, std::size_t b) const {
    return std::hypot(kMinOrientation_rad,
                      kRotationDrift_rad_per_m * std::abs(path_m_[b] - path_m_[a])) +
           std::abs(tracking_gaps_[b].rotation_rad - tracking_gaps_[a].rotation_rad);
}

bool DriftModel::allows(std::size_t a,
                        std::size_t b,
                        const Eigen::Isometry3d& T_a_b,
                        const Eigen::Isometry3d& expected,
                        double measured_sigma_m) const {
    const double moved_m = (T_a_b.translation() - expected.translation()).norm();
    const double turned_rad = base::angle_rad(T_a_b.linear().transpose() * expected.linear());
    return moved_m < kNumSigmas * std::hypot(position_sigma_m(a, b), measured_sigma_m) &&
           turned_rad < kNumSigmas * orientation_sigma_rad(a, b);
}

}  // namespace divemesh::loops
