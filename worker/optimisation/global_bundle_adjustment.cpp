#include "worker/optimisation/global_bundle_adjustment.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "worker/base/rotation_vector.hpp"
#include "worker/optimisation/expected_path_error.hpp"
#include "worker/optimisation/inertial_factors.hpp"
#include "worker/types/feature.hpp"

namespace divemesh::optimisation {
namespace {

constexpr int kMaxIterations = 15;
constexpr int kMaxSolves = 4;  // while the solution still moves
constexpr std::size_t kMaxObservations = 400'000;
// Scale error of disparities that are interpolated and triangulated with noise. Neither residuals
// nor errors of the calibration show it, so it is added (Schmidt's consider parameters).
constexpr double kScaleSigma = 0.0015;
constexpr std::size_t kMaxCovariances = 64;  // keyframes; covariances change slowly between them
constexpr std::int64_t kRateInterval_ns = 20'000'000;

// Returns n such that every n-th landmark makes no more than kMaxObservations.
std::size_t stride_for(const std::vector<types::Landmark>& landmarks) {
    std::size_t num_observations = 0;
    for (const types::Landmark& landmark : landmarks)
        num_observations += landmark.observations.size();
    return 1 + num_observations / kMaxObservations;
}

// Returns the reprojection RMS of every `stride`-th landmark, i.e. of the adjusted ones.
double reprojection_rms_px(const types::RectifiedRig& rig,
                           const std::vector<types::Keyframe>& keyframes,
                           const std::vector<types::Landmark>& landmarks,
                           std::size_t stride) {
    double squares = 0.0;
    std::int64_t num = 0;
    for (std::size_t i = 0; i < landmarks.size(); i += stride) {
        const types::Landmark& landmark = landmarks[i];
        for (const types::LandmarkObservation& seen : landmark.observations) {
            const auto& keyframe = keyframes[static_cast<std::size_t>(seen.keyframe)];
            const Eigen::Vector3d p_cam = keyframe.T_world_cam.inverse() * landmark.p_world;
            if (p_cam.z() < 0.02) continue;
            squares += (rig.pixel(p_cam) - types::measurement_px(seen).head<2>()).squaredNorm();
            ++num;
        }
    }
    return num > 0 ? std::sqrt(squares / static_cast<double>(num)) : 0.0;
}

struct Uncertainty {
    types::CovarianceTrack covariances;
    types::CovarianceTrack drift;  // with the calibration taken as exact
    types::PathUncertainty path;
    std::optional<double> last_step_sigmas;  // max over keyframes; nullopt: not known
};

// Returns the RMS over the axes of a move in its standard deviations; infinite if these are not
// determined.
double in_sigmas(const Eigen::Vector3d& move_m, const Eigen::Matrix3d& covariance_m2) {
    const double squared = move_m.dot(covariance_m2.ldlt().solve(move_m));
    return squared >= 0.0 ? std::sqrt(squared / 3.0) : std::numeric_limits<double>::infinity();
}

// Returns how the state changes with time, by the IMU around it, or before or after it at an end of
// the readings; zero where there are none.
BodyRates rates_at(std::int64_t timestamp_ns,
                   const BodyState& state,
                   const imu::InertialPrior& inertial,
                   const WorldReference& reference) {
    constexpr double kRateInterval_s = 1e-9 * kRateInterval_ns;
    BodyRates rates;
    for (const std::int64_t before_ns : {kRateInterval_ns / 2, std::int64_t{0}, kRateInterval_ns}) {
        const std::int64_t from_ns = timestamp_ns - before_ns;
        const std::int64_t to_ns = from_ns + kRateInterval_ns;
        const auto rotation = inertial.integral(from_ns, to_ns);
        if (!rotation) continue;
        rates.angular_velocity_world =
            state.q_world_imu * (base::vector_from_rotation(rotation->q_from_to) / kRateInterval_s);
        if (const auto motion = inertial.motion(from_ns, to_ns))
            rates.acceleration_world =
                state.q_world_imu * (motion->delta_velocity / kRateInterval_s) +
                imu::kGravity_m_s2 * reference.gravity_direction_world;
        break;
    }
    return rates;
}

std::vector<BodyRates> rates_of(const imu::InertialPrior& inertial,
                                const std::vector<types::Keyframe>& keyframes,
                                const std::vector<BodyState>& states,
                                const WorldReference& reference) {
    std::vector<BodyRates> rates;
    for (std::size_t k = 0; k < states.size(); ++k)
        rates.push_back(rates_at(keyframes[k].timestamp_ns, states[k], inertial, reference));
    return rates;
}

Uncertainty relative_to_first(BundleAdjustment& bundle_adjustment,
                              const std::vector<types::Keyframe>& keyframes,
                              std::vector<BodyState>& states,
                              const CalibrationUncertainty& calibration,
                              const std::vector<BodyRates>& rates) {
    const std::size_t stride = 1 + (states.size() - 1) / kMaxCovariances;
    std::vector<std::size_t> chosen;
    for (std::size_t k = 0; k + 1 < states.size(); k += stride) chosen.push_back(k);
    chosen.push_back(states.size() - 1);
    std::vector<BodyState*> of;
    of.reserve(chosen.size());
    for (const std::size_t k : chosen) of.push_back(&states[k]);
    const JointCovariance in_world = bundle_adjustment.covariances(of, calibration, rates);
    if (in_world.states.empty()) return {};
    std::vector<Eigen::Vector3d> positions;
    Eigen::VectorXd by_scale(3 * std::ssize(of));
    for (const BodyState* state : of) {
        by_scale.segment<3>(3 * std::ssize(positions)) =
            kScaleSigma * (state->p_world_imu - states.front().p_world_imu);
        positions.push_back(state->p_world_imu);
    }
    const Eigen::MatrixXd shared_m2 =
        in_world.by_calibration_m * in_world.by_calibration_m.transpose() +
        by_scale * by_scale.transpose();
    const Eigen::MatrixXd whole_m2 = in_world.positions_m2 + shared_m2;
    const Eigen::Matrix3d R_world_first = states.front().q_world_imu.toRotationMatrix();
    Uncertainty result;
    result.last_step_sigmas = 0.0;
    for (std::size_t i = 0; i < of.size(); ++i) {
        const Eigen::Vector3d along = by_scale.segment<3>(3 * static_cast<Eigen::Index>(i));
        const Eigen::Matrix3d position_m2 =
            in_world.states[i].position_m2 + along * along.transpose();
        result.covariances.push_back(
            {keyframes[chosen[i]].timestamp_ns,
             R_world_first.transpose() * position_m2 * R_world_first,
             R_world_first.transpose() * in_world.states[i].rotation_rad2 * R_world_first});
        const auto at = 3 * static_cast<Eigen::Index>(i);
        result.drift.push_back(result.covariances.back());
        const Eigen::Matrix3d drift_m2 = in_world.positions_m2.block<3, 3>(at, at);
        result.drift.back().position_m2 = R_world_first.transpose() * drift_m2 * R_world_first;
        if (chosen[i] == 0) continue;
        const Eigen::Vector3d& move_m = bundle_adjustment.last_moves_m()[chosen[i]];
        result.last_step_sigmas = std::max(*result.last_step_sigmas, in_sigmas(move_m, drift_m2));
    }
    result.path = after_alignment(positions, whole_m2);
    result.path.vertical_scale_sigma = vertical_scale_sigma(positions, in_world.positions_m2);
    result.path.scale_sigma = scale_sigma(positions, whole_m2);
    result.path.shared_scale_sigma = scale_sigma(positions, shared_m2);
    result.path.spread_m2 = spread_m2(positions);
    return result;
}

// Returns evenly spread keyframes, and those on both sides of every motion that was not measured:
// between two of them a correction of the path is smooth.
std::vector<std::size_t> anchors_of(const types::Track& track) {
    const std::vector<types::Keyframe>& keyframes = track.keyframes;
    const std::size_t stride = 1 + (keyframes.size() - 1) / kMaxCovariances;
    std::vector<std::size_t> anchors;
    std::size_t num_at_breaks = 0;
    const auto add = [&](std::size_t k) {
        if (anchors.empty() || anchors.back() < k) anchors.push_back(k);
    };
    for (std::size_t k = 0; k < keyframes.size(); ++k) {
        const bool is_after_break =
            k > 0 && (keyframes[k].segment != keyframes[k - 1].segment ||
                      std::ranges::any_of(track.breaks_ns, [&](std::int64_t break_ns) {
                          return break_ns > keyframes[k - 1].timestamp_ns &&
                                 break_ns <= keyframes[k].timestamp_ns;
                      }));
        if (is_after_break && num_at_breaks < kMaxCovariances) {
            add(k - 1);
            add(k);
            num_at_breaks += 2;
        }
        if (k % stride == 0 || k + 1 == keyframes.size()) add(k);
    }
    return anchors;
}

types::PathPrior path_prior(BundleAdjustment& bundle_adjustment,
                            const types::Track& track,
                            std::vector<BodyState>& states,
                            const CalibrationUncertainty& calibration,
                            const std::vector<BodyRates>& rates) {
    types::PathPrior prior;
    std::vector<BodyState*> of;
    for (const std::size_t k : anchors_of(track)) {
        of.push_back(&states[k]);
        prior.timestamps_ns.push_back(track.keyframes[k].timestamp_ns);
    }
    JointCovariance joint = bundle_adjustment.covariances(of, calibration, rates, JointOf::Poses);
    if (joint.states.empty()) return {};
    prior.apart_m.assign(of.size(), 0.0);
    prior.drift = std::move(joint.poses);
    prior.shared.resize(prior.drift.rows(), joint.poses_by_calibration.cols() + 1);
    prior.shared.leftCols(joint.poses_by_calibration.cols()) = joint.poses_by_calibration;
    prior.shared.rightCols<1>().setZero();
    for (std::size_t i = 0; i < of.size(); ++i)
        prior.shared.rightCols<1>().segment<3>(6 * static_cast<Eigen::Index>(i)) =
            kScaleSigma * (of[i]->p_world_imu - of.front()->p_world_imu);
    return prior;
}

// Expresses a prior in the axes of another world.
void rotate(const Eigen::Quaterniond& q_new_old, types::PathPrior& prior) {
    const Eigen::Matrix3d R = q_new_old.toRotationMatrix();
    for (Eigen::Index row = 0; row < prior.drift.rows(); row += 3) {
        prior.drift.middleRows<3>(row) = (R * prior.drift.middleRows<3>(row)).eval();
        prior.shared.middleRows<3>(row) = (R * prior.shared.middleRows<3>(row)).eval();
    }
    for (Eigen::Index column = 0; column < prior.drift.cols(); column += 3)
        prior.drift.middleCols<3>(column) =
            (prior.drift.middleCols<3>(column) * R.transpose()).eval();
}

}  // namespace

GlobalBundleAdjustment adjust_globally(types::Track& track,
                                       const imu::InertialPrior& inertial,
                                       const std::vector<KnownMotion>& known,
                                       const CalibrationUncertainty& calibration,
                                       const base::ProgressCallback& progress,
                                       const Progress& at,
                                       WithPrior with_prior) {
    const types::RectifiedRig& rig = track.rig;
    std::vector<types::Keyframe>& keyframes = track.keyframes;
    std::vector<types::Landmark>& landmarks = track.landmarks;
    std::vector<BodyState> states;
    states.reserve(keyframes.size());
    for (const types::Keyframe& keyframe : keyframes)
        states.push_back(
            BodyState::at(keyframe.T_world_cam * rig.T_imu_cam.inverse(), inertial.bias()));
    BundleAdjustment bundle_adjustment(rig);
    for (std::size_t k = 0; k < states.size(); ++k) bundle_adjustment.add_state(states[k], k == 0);
    const std::size_t stride = stride_for(landmarks);
    for (std::size_t i = 0; i < landmarks.size(); i += stride)
        for (const types::LandmarkObservation& seen : landmarks[i].observations)
            bundle_adjustment.add_observation(states[static_cast<std::size_t>(seen.keyframe)],
                                              landmarks[i].p_world,
                                              types::measurement_px(seen),
                                              types::kFeatureSigma_px);
    for (const KnownMotion& motion : known)
        bundle_adjustment.add_motion(states[motion.to - 1],
                                     states[motion.to],
                                     motion.T_before_to,
                                     motion.sigma_m,
                                     motion.sigma_rad);
    WorldReference reference;
    add_inertial_factors(bundle_adjustment, inertial, keyframes, states, reference);
    types::SolverOutcome outcome;
    Uncertainty uncertainty;
    for (int i = 0; i < kMaxSolves && (i == 0 || outcome.still_moving()); ++i) {
        const types::SolverOutcome before = outcome;
        outcome = bundle_adjustment.solve_sparse(kMaxIterations, progress, at);
        outcome.num_iterations += before.num_iterations;
        if (i > 0) outcome.initial_cost = before.initial_cost;
        if (outcome.failed()) break;
        uncertainty = relative_to_first(bundle_adjustment,
                                        keyframes,
                                        states,
                                        calibration,
                                        rates_of(inertial, keyframes, states, reference));
        if (uncertainty.last_step_sigmas) outcome.last_step_sigmas = *uncertainty.last_step_sigmas;
    }
    types::PathPrior prior;
    if (with_prior == WithPrior::Yes && !outcome.failed())
        prior = path_prior(bundle_adjustment,
                           track,
                           states,
                           calibration,
                           rates_of(inertial, keyframes, states, reference));
    const Eigen::Quaterniond q_level_world = gravity_alignment(inertial, reference);
    rotate(q_level_world, prior);
    for (std::size_t k = 0; k < states.size(); ++k)
        keyframes[k].T_world_cam = q_level_world * states[k].T_world_imu() * rig.T_imu_cam;
    for (types::Landmark& landmark : landmarks) landmark.p_world = q_level_world * landmark.p_world;
    return {reprojection_rms_px(rig, keyframes, landmarks, stride),
            std::move(uncertainty.covariances),
            std::move(uncertainty.drift),
            uncertainty.path,
            std::move(outcome),
            stride,
            std::move(prior)};
}

}  // namespace divemesh::optimisation
