#include "worker/pipeline/optimise_track.hpp"

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "worker/base/free_memory.hpp"
#include "worker/calibration/calibration_refinement.hpp"
#include "worker/calibration/calibration_uncertainty.hpp"
#include "worker/imu/inertial_prior.hpp"
#include "worker/loops/close_loops.hpp"
#include "worker/loops/drift_model.hpp"
#include "worker/loops/find_loops.hpp"
#include "worker/loops/motions_in_sight.hpp"
#include "worker/optimisation/expected_path_error.hpp"
#include "worker/optimisation/follow_keyframes.hpp"
#include "worker/optimisation/frame_covariances.hpp"
#include "worker/optimisation/global_bundle_adjustment.hpp"
#include "worker/pipeline/known_motions.hpp"
#include "worker/pipeline/lever_arm.hpp"
#include "worker/pipeline/other_start.hpp"
#include "worker/pipeline/segments_apart.hpp"
#include "worker/pipeline/solver_findings.hpp"
#include "worker/pipeline/track_agreement.hpp"

namespace divemesh::pipeline {
namespace {

constexpr int kMaxLeverArmRounds = 3;

// Notes in the prior how far its keyframes were set apart.
void note_apart(const std::vector<types::Keyframe>& as_estimated,
                const std::vector<types::Keyframe>& apart,
                types::PathPrior& prior) {
    std::size_t k = 0;
    for (std::size_t i = 0; i < prior.timestamps_ns.size(); ++i) {
        while (apart[k].timestamp_ns != prior.timestamps_ns[i]) ++k;
        prior.apart_m[i] =
            apart[k].T_world_cam.translation().x() - as_estimated[k].T_world_cam.translation().x();
    }
}

// Runs the steps of optimise_track, and runs them again with less if the result is worse.
class TrackOptimiser {
public:
    TrackOptimiser(const types::Track& track,
                   const types::Recording& recording,
                   const ReconstructionOptions& options,
                   const keyframes::KeyframeStore& store,
                   const types::RigAlignment& alignment,
                   optimisation::WithPrior with_prior,
                   const base::ProgressCallback& progress)
        : track_(track),
          recording_(recording),
          options_(options),
          store_(store),
          alignment_(alignment),
          with_prior_(with_prior),
          progress_(progress),
          inertial_(recording, options, track.left_out),
          drift_(track.keyframes, track.landmarks, &inertial_, loops::motions_in_sight(track)) {
        inertial_.set_pressure_error(track.pressure_error_m);
    }

    types::OptimisedTrack run() {
        find_loops();
        types::Track closed = closed_track();
        refine_calibration(closed);
        if (adjust(std::move(closed)))
            refine_lever_arm();
        else
            adjust_otherwise();
        return std::move(result_);
    }

private:
    void find_loops();
    types::Track closed_track();
    void drop_loops(const std::string& why);
    void refine_calibration(const types::Track& closed);
    bool adjust(types::Track closed);
    void refine_lever_arm();
    void leave_lever_arm(types::OptimisedTrack earlier);
    void adjust_otherwise();
    void leave_as_tracked();
    void take(types::Track& closed, const optimisation::GlobalBundleAdjustment& adjusted);
    void add(const std::vector<Finding>& findings) {
        result_.findings.insert(result_.findings.end(), findings.begin(), findings.end());
    }
    Progress at(double fraction) const {
        Progress progress;
        progress.fraction = fraction;
        return progress;
    }

    const types::Track& track_;
    const types::Recording& recording_;
    const ReconstructionOptions& options_;
    const keyframes::KeyframeStore& store_;
    const types::RigAlignment& alignment_;
    optimisation::WithPrior with_prior_;
    const base::ProgressCallback& progress_;
    imu::InertialPrior inertial_;
    loops::DriftModel drift_;
    std::vector<loops::Loop> loops_;                  // the accepted ones
    std::optional<types::SolverOutcome> pose_graph_;  // the last one that closed them
    calibration::CalibrationRefinement refinement_;
    types::OptimisedTrack result_;
    std::size_t num_findings_before_adjusting_ = 0;
};

void TrackOptimiser::find_loops() {
    if (!options_.close_loops) return;
    loops::FoundLoops found = loops::find_loops(
        track_, drift_, store_, static_cast<std::uint64_t>(options_.seed), progress_);
    loops_ = std::move(found.loops);
    result_.statistics.loops = found.statistics;
    base::return_freed_memory();
}

// Returns the parts of the track that change from here on, with the accepted loops closed. If
// closing them makes the track worse, it drops the loops.
types::Track TrackOptimiser::closed_track() {
    types::Track closed;
    closed.rig = track_.rig;
    closed.odometry = track_.odometry;
    closed.breaks_ns = track_.breaks_ns;
    closed.keyframes = track_.keyframes;
    closed.landmarks = track_.landmarks;
    closed.imu_alignment = track_.imu_alignment;
    closed.left_out = track_.left_out;
    const auto outcome =
        loops::close_loops(closed.rig, loops_, drift_, closed.keyframes, closed.landmarks);
    if (!outcome) return closed;
    result_.statistics.pose_graph.add(*outcome);
    pose_graph_ = *outcome;
    // Neither the reprojection error nor the distance moved is checked here: the bundle adjustment
    // moves landmarks and keyframes again, and adjust() checks both then.
    const types::TrackCheck check{agreement(track_, track_, 1, drift_),
                                  agreement(closed, track_, 1, drift_)};
    if (!outcome->failed() && !contradicts_odometry(check)) return closed;
    drop_loops(outcome->failed() ? "their pose graph failed: " + outcome->message
                                 : "with them the path contradicts the motion from frame to frame");
    return closed_track();
}

void TrackOptimiser::drop_loops(const std::string& why) {
    result_.findings.push_back(
        {Severity::Warning,
         "loops_not_taken",
         "",
         std::to_string(loops_.size()) +
             " places that looked like ones seen before were left out: " + why,
         "the drift is unchecked now: place markers on the next dive, or check the calibration"});
    loops_.clear();
    pose_graph_.reset();
    result_.statistics.loops.num_accepted = 0;
    result_.statistics.loops.largest_correction_m = 0.0;
}

void TrackOptimiser::refine_calibration(const types::Track& closed) {
    refinement_ = calibration::refine_calibration(
        closed, recording_, options_, alignment_, inertial_, progress_, at(0.4));
    result_.calibration = refinement_.calibration;
    for (const types::SolverOutcome& outcome : refinement_.solves) {
        result_.statistics.calibration.add(outcome);
        add(solver_findings(
            outcome, "calibration_not_converged", "the refinement of the calibration"));
    }
}

// Adjusts the whole dive with the refined calibration. Returns false and takes no result if the
// track got worse.
bool TrackOptimiser::adjust(types::Track closed) {
    num_findings_before_adjusting_ = result_.findings.size();
    types::ImuAlignment alignment = result_.calibration.applied_alignment();
    alignment.q_body_imu.setIdentity();  // apply_calibration() rotates the rig
    inertial_.align(alignment);
    calibration::apply_calibration(recording_.rig(), result_.calibration, closed);
    base::return_freed_memory();
    refinement_.calibration = result_.calibration;
    const optimisation::GlobalBundleAdjustment adjusted = optimisation::adjust_globally(
        closed,
        inertial_,
        known_motions(track_, closed, inertial_, drift_),
        calibration::calibration_uncertainty(recording_.rig(), closed.rig, refinement_, alignment_),
        progress_,
        at(0.6),
        with_prior_);
    result_.statistics.bundle_adjustment.add(adjusted.outcome);
    types::TrackCheck& check = result_.statistics.check;
    check.before = agreement(track_, track_, adjusted.landmark_stride, drift_);
    check.after = agreement(closed, track_, adjusted.landmark_stride, drift_);
    // Another calibration moves the path by more than its drift.
    check.moved_rms_sigmas =
        moved_rms_sigmas(track_.keyframes,
                         closed.keyframes,
                         result_.calibration.is_applied() ? adjusted.covariances : adjusted.drift,
                         drift_);
    const bool better = !adjusted.outcome.failed() && !is_worse(check);
    if (better || adjusted.outcome.failed())
        add(solver_findings(
            adjusted.outcome, "adjustment_not_converged", "bundle adjustment of the whole dive"));
    if (!better) return false;
    take(closed, adjusted);
    return true;
}

// Adjusts again with the IMU where the accelerometer tells that it is, until it stays there: a path
// that was adjusted with a wrong lever arm hides a part of it. The result stays as it was if this
// does not help.
void TrackOptimiser::refine_lever_arm() {
    if (!options_.align_imu || !inertial_.has_accelerometer()) return;
    const types::OptimisedTrack as_stated = result_;
    types::RefinedCalibration& calibration = result_.calibration;
    for (int round = 0; round < kMaxLeverArmRounds; ++round) {
        const auto found = find_lever_arm(result_, recording_, track_.left_out);
        if (!found) return;
        calibration.lever_arm_sigma_m = found->sigma_m;
        if (calibration.lever_arm_applied && found->is_still) return;
        calibration.lever_arm_m = found->from_stated_m;
        if (!calibration.lever_arm_applied && !found->is_significant) return;
        calibration.lever_arm_applied = true;
        result_.findings.resize(num_findings_before_adjusting_);
        if (!adjust(closed_track())) return leave_lever_arm(as_stated);
    }
}

// Goes back to an earlier result. What was estimated since stays, but is not used.
void TrackOptimiser::leave_lever_arm(types::OptimisedTrack earlier) {
    earlier.calibration.lever_arm_m = result_.calibration.lever_arm_m;
    earlier.calibration.lever_arm_sigma_m = result_.calibration.lever_arm_sigma_m;
    result_ = std::move(earlier);
}

// Adjusts again from another start, then without what may have misled the bundle adjustment: first
// the refined calibration, then the loops. If this does not help, the track stays as tracked.
void TrackOptimiser::adjust_otherwise() {
    result_.findings.resize(num_findings_before_adjusting_);
    types::Track restarted = closed_track();
    start_from_odometry(restarted);
    if (adjust(std::move(restarted))) return;
    if (result_.calibration.is_applied()) {
        result_.calibration.leave_as_stated();
        result_.findings.push_back({Severity::Warning,
                                    "calibration_not_taken",
                                    "",
                                    "the calibration estimated from the dive makes the path fit "
                                    "the measurements less well: "
                                    "the stated calibration was used",
                                    "calibrate the cameras and the IMU again"});
        if (adjust(closed_track())) return;
    }
    if (!loops_.empty()) {
        drop_loops("with them the path fits the measurements less well");
        if (adjust(closed_track())) return;
    }
    leave_as_tracked();
}

void TrackOptimiser::leave_as_tracked() {
    result_.findings.push_back(
        {Severity::Warning,
         "adjustment_not_taken",
         "",
         "bundle adjustment of the whole dive makes the path fit the measurements less well: the "
         "path is given as it was tracked, without bounds",
         "check the calibration of the cameras and the IMU"});
    types::Track closed = closed_track();
    types::TrackCheck& check = result_.statistics.check;
    check = {check.before, check.before, 0.0};  // of the result, not of what was rejected
    optimisation::GlobalBundleAdjustment unadjusted;
    unadjusted.reprojection_rms_px = result_.statistics.check.before.reprojection_rms_px;
    take(closed, unadjusted);
}

void TrackOptimiser::take(types::Track& closed,
                          const optimisation::GlobalBundleAdjustment& adjusted) {
    if (pose_graph_)
        add(solver_findings(*pose_graph_, "loops_not_converged", "the pose graph of the loops"));
    result_.statistics.reprojection_rms_px = adjusted.reprojection_rms_px;
    result_.prior = adjusted.prior;
    const std::vector<types::Keyframe> as_estimated = closed.keyframes;
    result_.max_depth_m =
        set_segments_apart(closed.rig, track_.statistics.median_depth_m, closed.keyframes);
    note_apart(as_estimated, closed.keyframes, result_.prior);
    result_.trajectory = optimisation::follow_keyframes(
        closed.odometry, track_.sigmas, closed.keyframes, closed.rig.T_imu_cam, track_.breaks_ns);
    result_.breaks_ns = track_.breaks_ns;
    result_.covariances = optimisation::covariances_at(adjusted.covariances,
                                                       closed.odometry,
                                                       track_.sigmas,
                                                       closed.keyframes,
                                                       closed.rig.T_imu_cam,
                                                       track_.breaks_ns);
    result_.statistics.path =
        optimisation::with_frames_between(adjusted.path, adjusted.covariances, result_.covariances);
    loops::add_residuals(loops_, closed.keyframes, result_.statistics.loops);
    result_.mapped = optimisation::posed_by(
        result_.trajectory, closed.keyframes, closed.rig.T_imu_cam, track_.mapped);
    result_.keyframes = std::move(closed.keyframes);
    result_.rig = closed.rig;
}

}  // namespace

types::OptimisedTrack optimise_track(const types::Track& track,
                                     const types::Recording& recording,
                                     const ReconstructionOptions& options,
                                     const keyframes::KeyframeStore& store,
                                     const types::RigAlignment& alignment,
                                     const base::ProgressCallback& progress,
                                     optimisation::WithPrior with_prior) {
    return TrackOptimiser(track, recording, options, store, alignment, with_prior, progress).run();
}

}  // namespace divemesh::pipeline
