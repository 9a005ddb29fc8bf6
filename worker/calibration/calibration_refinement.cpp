#include "worker/calibration/calibration_refinement.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "worker/base/rotation_vector.hpp"
#include "worker/calibration/calibration_priors.hpp"
#include "worker/calibration/calibration_problem.hpp"
#include "worker/calibration/undo_rolling_shutter.hpp"
#include "worker/camera/rerectifier.hpp"

namespace divemesh::calibration {
namespace {

constexpr std::size_t kMinCalibrationKeyframes = 5;
constexpr double kSignificant = 4.0;  // sigmas
constexpr double kMinOffset_s = 1e-3;
constexpr double kMinRotation_rad = 1.7e-3;
constexpr double kMinRateError = 5e-3;  // less may be the focal length's
// The sigmas of all parameters of both lenses together, with the weights of systematic errors:
// exact rigs are below 1.3, typical calibrations from 4 on.
constexpr double kSignificantLenses = 3.0;
constexpr double kMinReadout_s = 3e-3;
// A quarter of the landmarks tells whether a readout time deserves a solve with all of them.
constexpr std::size_t kReadoutStride = 4;
constexpr double kMayBeSignificant = 2.0;  // sigmas, of a quarter of the landmarks

bool significant(const Eigen::VectorXd& value, const Eigen::MatrixXd& covariance) {
    return value.dot(covariance.ldlt().solve(value)) >
           kSignificant * kSignificant * static_cast<double>(value.size());
}

void take_imu(const CalibrationProblem& problem, types::RefinedCalibration& result) {
    const CalibrationUnknowns& found = problem.unknowns();
    const CalibrationSigmas& sigmas = problem.sigmas();
    result.imu = {
        found.time_offset_s, base::rotation_from_vector(found.misalignment), found.rate_error};
    result.time_offset_sigma_s = sigmas.time_offset_s;
    result.rotation_sigma_rad = sigmas.misalignment.diagonal().cwiseMax(0.0).cwiseSqrt();
    result.time_offset_applied =
        std::abs(found.time_offset_s) > std::max(kMinOffset_s, kSignificant * sigmas.time_offset_s);
    // What tracking found stays unless the estimate is nearer to none at all.
    if (!result.time_offset_applied &&
        std::abs(found.time_offset_s) <
            std::abs(found.time_offset_s - result.tracked_time_offset_s))
        result.tracked_time_offset_s = 0.0;
    result.rotation_applied = found.misalignment.norm() > kMinRotation_rad &&
                              significant(found.misalignment, sigmas.misalignment);
    result.rate_error_sigma = sigmas.rate_error.diagonal().cwiseMax(0.0).cwiseSqrt();
    result.rate_error_applied =
        found.rate_error.norm() > kMinRateError && significant(found.rate_error, sigmas.rate_error);
}

void take_lenses(const CalibrationProblem& problem, types::RefinedCalibration& result) {
    const LensChanges found = problem.unknowns().lenses;
    const LensCovariance covariance = problem.sigmas().lenses;
    const LensChanges sigmas = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
    result.lenses = split(found);
    result.lens_sigmas = {sigmas.head<types::LensChange::kSize>(),
                          sigmas.tail<types::LensChange::kSize>()};
    result.lens_shift_px = problem.shift_px(found);
    result.lenses_applied =
        found.dot(covariance.ldlt().solve(found)) > kSignificantLenses * kSignificantLenses;
}

void take_readout_time(const CalibrationProblem& problem, types::RefinedCalibration& result) {
    result.readout_time_s = problem.unknowns().readout_time_s;
    result.readout_time_sigma_s = problem.sigmas().readout_time_s;
    result.readout_shift_px = problem.shift_by_readout_px(result.readout_time_s);
}

bool exceeds(const types::RefinedCalibration& found, double sigmas) {
    return std::abs(found.readout_time_s) >
           std::max(kMinReadout_s, sigmas * found.readout_time_sigma_s);
}

// Returns whether a readout time is significant and is in `result`, with the lenses that fit it in
// `problem`. Adds how the solve ended to `solves` if so; otherwise nothing is used of it.
bool refine_readout_time(CalibrationProblem& problem,
                         types::RefinedCalibration& result,
                         std::vector<types::SolverOutcome>& solves,
                         const base::ProgressCallback& progress,
                         const Progress& at) {
    problem.thin(kReadoutStride);
    if (problem.solve({.readout_time = true}, progress, at).failed()) return false;
    take_readout_time(problem, result);
    if (!exceeds(result, kMayBeSignificant)) return false;
    problem.thin(1);
    const types::SolverOutcome outcome =
        problem.solve({.lenses = true, .readout_time = true}, progress, at);
    if (outcome.failed()) return false;
    take_readout_time(problem, result);
    result.readout_time_applied = exceeds(result, kSignificant);
    if (result.readout_time_applied) solves.push_back(outcome);
    return result.readout_time_applied;
}

// Moves the observations to where they would be if the pairs had been rectified with the changed
// lenses.
void apply_lenses(const types::Rig& rig,
                  const types::RectifiedRig& rectified,
                  const std::array<types::LensChange, 2>& lenses,
                  types::Track& track) {
    const camera::Rerectifier rerectifier(rig, rectified, lenses);
    for (types::Landmark& landmark : track.landmarks) {
        for (types::LandmarkObservation& seen : landmark.observations) {
            const Eigen::Vector3f moved =
                rerectifier.moved(Eigen::Vector3d(seen.u_px, seen.v_px, seen.disparity_px))
                    .cast<float>();
            seen.u_px = moved.x();
            seen.v_px = moved.y();
            seen.disparity_px = moved.z();
        }
    }
}

}  // namespace

CalibrationRefinement refine_calibration(const types::Track& track,
                                         const types::Recording& recording,
                                         const ReconstructionOptions& options,
                                         const types::RigAlignment& alignment,
                                         const imu::InertialPrior& inertial,
                                         const base::ProgressCallback& progress,
                                         const Progress& at) {
    CalibrationRefinement refinement;
    types::RefinedCalibration& result = refinement.calibration;
    result.tracked_time_offset_s = track.imu_alignment.time_offset_s;
    if (track.keyframes.size() < kMinCalibrationKeyframes || track.landmarks.empty())
        return refinement;
    CalibrationProblem problem(track, recording, alignment, inertial);
    const auto solved = [&](const FreeUnknowns& free) {
        refinement.solves.push_back(problem.solve(free, progress, at));
        return !refinement.solves.back().failed();
    };
    const auto use_imu = [&] {
        take_imu(problem, result);
        problem.hold_rate_error(result.applied_alignment().rate_error);
    };
    const bool align = options.align_imu && inertial.has_gyroscope();
    if (align) {
        if (!solved({})) return refinement;
        use_imu();
    }
    if (!options.refine_lenses || !solved({.lenses = true})) return refinement;
    take_lenses(problem, result);
    refinement.lens_covariance = problem.sigmas().lenses;
    if (result.lenses_applied && align) {
        problem.hold_lenses(joined(result.lenses));
        if (solved({})) use_imu();
    }
    if (!problem.knows_motion()) return refinement;
    if (!refine_readout_time(problem, result, refinement.solves, progress, at)) return refinement;
    take_lenses(problem, result);
    refinement.lens_covariance = problem.sigmas().lenses;
    if (!result.lenses_applied) {
        problem.hold_lenses(LensChanges::Zero());
        if (solved({.readout_time = true})) take_readout_time(problem, result);
    }
    if (align && solved({})) use_imu();
    return refinement;
}

types::Rig refined_rig(const types::Rig& rig, const types::RefinedCalibration& calibration) {
    types::Rig refined = rig;
    if (calibration.lenses_applied) {
        refined.cam0 = camera::changed_camera(rig.cam0, calibration.lenses[0]);
        refined.cam1 = camera::changed_camera(rig.cam1, calibration.lenses[1]);
    }
    const Eigen::Isometry3d T_imu_body =
        Eigen::Translation3d(-calibration.applied_lever_arm_m()) *
        Eigen::Isometry3d(calibration.applied_alignment().q_body_imu.conjugate().normalized());
    refined.T_imu_cam0 = T_imu_body * rig.T_imu_cam0;
    refined.T_imu_cam1 = T_imu_body * rig.T_imu_cam1;
    return refined;
}

void apply_calibration(const types::Rig& rig,
                       const types::RefinedCalibration& calibration,
                       types::Track& track) {
    const types::RectifiedRig rectified = track.rig;
    if (calibration.rotation_applied || calibration.lever_arm_applied) {
        const Eigen::Isometry3d T_body_imu =
            Eigen::Isometry3d(calibration.applied_alignment().q_body_imu) *
            Eigen::Translation3d(calibration.applied_lever_arm_m());
        track.rig.T_imu_cam = T_body_imu.inverse() * track.rig.T_imu_cam;
        for (types::StampedPose& pose : track.odometry)
            pose.T_world_imu = pose.T_world_imu * T_body_imu;
    }
    if (calibration.lenses_applied) apply_lenses(rig, rectified, calibration.lenses, track);
    if (calibration.readout_time_applied)
        undo_rolling_shutter(rig, calibration.readout_time_s, track);
}

}  // namespace divemesh::calibration
