#include "worker/estimation/global_adjustment.hpp"

#include <cmath>

#include "worker/estimation/adjustment.hpp"
#include "worker/steps/feature.hpp"

namespace divemesh::worker {
namespace {

constexpr int kMaxIterations = 15;
constexpr std::size_t kMostObservations = 400'000;
constexpr double kFirstBiasSigma = 0.02;  // rad/s
// The AHRS errs by half a degree, slowly: neighbours in time say the same thing again.
constexpr double kAhrsSigma_rad = 0.01;
constexpr double kAhrsCorrelation_s = 12.0;

Eigen::Vector3d measurement_px(const LandmarkObservation& seen) {
    return {seen.u_px, seen.v_px, seen.disparity_px};
}

double seconds(std::int64_t interval_ns) { return 1e-9 * static_cast<double>(interval_ns); }

// Every n-th landmark, so that no more than kMostObservations remain.
std::size_t stride_for(const std::vector<Landmark>& landmarks) {
    std::size_t num_observations = 0;
    for (const Landmark& landmark : landmarks) num_observations += landmark.observations.size();
    return 1 + num_observations / kMostObservations;
}

void add_inertial(Adjustment& adjustment,
                  const InertialPrior& inertial,
                  const std::vector<Keyframe>& keyframes,
                  std::vector<BodyState>& states) {
    bool bias_held = false;
    for (std::size_t k = 0; k < states.size(); ++k) {
        const std::int64_t now_ns = keyframes[k].timestamp_ns;
        const std::int64_t before_ns = k > 0 ? keyframes[k - 1].timestamp_ns : now_ns;
        if (const auto known = inertial.absolute(now_ns); known && k > 0) {
            const double times = kAhrsCorrelation_s / std::max(0.1, seconds(now_ns - before_ns));
            adjustment.add_orientation(
                states[k], *known, kAhrsSigma_rad * std::sqrt(std::max(1.0, times)));
        }
        const auto turn = inertial.integral(before_ns, now_ns);
        if (!turn) continue;
        adjustment.add_turn(states[k - 1], states[k], *turn, inertial.gyroscope_random_walk());
        if (!bias_held)
            adjustment.add_bias(states[k - 1], Eigen::Vector3d::Zero(), kFirstBiasSigma);
        bias_held = true;
    }
}

double reprojection_rms_px(const RectifiedRig& rig,
                           const std::vector<Keyframe>& keyframes,
                           const std::vector<Landmark>& landmarks) {
    double squares = 0.0;
    std::int64_t num = 0;
    for (const Landmark& landmark : landmarks) {
        for (const LandmarkObservation& seen : landmark.observations) {
            const auto& keyframe = keyframes[static_cast<std::size_t>(seen.keyframe)];
            const Eigen::Vector3d p_cam = keyframe.T_world_cam.inverse() * landmark.p_world;
            if (p_cam.z() < 0.02) continue;
            squares += (rig.pixel(p_cam) - measurement_px(seen).head<2>()).squaredNorm();
            ++num;
        }
    }
    return num > 0 ? std::sqrt(squares / static_cast<double>(num)) : 0.0;
}

}  // namespace

double adjust_dive(const RectifiedRig& rig,
                   const InertialPrior& inertial,
                   std::vector<Keyframe>& keyframes,
                   std::vector<Landmark>& landmarks,
                   const ProgressCallback& progress,
                   const Progress& at) {
    std::vector<BodyState> states;
    states.reserve(keyframes.size());
    for (const Keyframe& keyframe : keyframes)
        states.push_back(
            BodyState::at(keyframe.T_world_cam * rig.T_imu_cam.inverse(), inertial.bias()));
    Adjustment adjustment(rig);
    for (std::size_t k = 0; k < states.size(); ++k) adjustment.add_state(states[k], k == 0);
    const std::size_t stride = stride_for(landmarks);
    for (std::size_t i = 0; i < landmarks.size(); i += stride)
        for (const LandmarkObservation& seen : landmarks[i].observations)
            adjustment.add_observation(states[static_cast<std::size_t>(seen.keyframe)],
                                       landmarks[i].p_world,
                                       measurement_px(seen),
                                       kFeatureSigma_px);
    add_inertial(adjustment, inertial, keyframes, states);
    adjustment.solve(Adjustment::Size::Dive, kMaxIterations, progress, at);
    for (std::size_t k = 0; k < states.size(); ++k)
        keyframes[k].T_world_cam = states[k].T_world_imu() * rig.T_imu_cam;
    return reprojection_rms_px(rig, keyframes, landmarks);
}

}  // namespace divemesh::worker
