#include "worker/pipeline/solver_findings.hpp"

#include <cmath>

#include "worker/base/text.hpp"
#include "worker/pipeline/tracking_findings.hpp"

namespace divemesh::pipeline {
namespace {

// Share of the solves of one kind. A few frames may be left to the motion model; more failures are
// a sign that images or sensors do not fit.
constexpr double kMaxFailedShare = 0.05;
// Share of the motions between two frames.
constexpr double kMaxStillMovingShare = 0.05;
// Ten times the noise of a feature, u and v together. The sliding window rejects single
// observations at half of it, so an RMS as large as this is not a fit.
constexpr double kDiverged_px = 3.5;
// The bundle adjustment moves keyframes by fractions of the distance between them. A path several
// times as long as the odometry's has fallen apart. The slack is for rigs that stand still.
constexpr double kDivergedPath = 3.0;
constexpr double kPathSlack_m = 1.0;

bool is_above(double share, std::int64_t num, std::int64_t num_solves) {
    return static_cast<double>(num) > share * static_cast<double>(num_solves);
}

std::string cases(std::int64_t num, std::int64_t num_solves) {
    return std::to_string(num) + " of " + std::to_string(num_solves) + " cases";
}

void add_failed(const types::SolverTally& tally,
                const std::string& what,
                std::vector<Finding>& findings) {
    if (is_above(kMaxFailedShare, tally.num_failed, tally.num_solves))
        findings.push_back({Severity::Warning,
                            "solver_failed",
                            "",
                            what + " failed in " + cases(tally.num_failed, tally.num_solves) +
                                ": poses there may be off",
                            kTrackBetter});
}

void add_still_moving(const types::SolverTally& tally,
                      const std::string& what,
                      std::vector<Finding>& findings) {
    if (is_above(kMaxStillMovingShare, tally.num_still_moving, tally.num_solves))
        findings.push_back({Severity::Warning,
                            "solver_not_converged",
                            "",
                            what + " had not converged at its limit of iterations in " +
                                cases(tally.num_still_moving, tally.num_solves) +
                                ": poses there may be off",
                            kTrackBetter});
}

std::string last_step(const types::SolverOutcome& outcome) {
    if (outcome.last_step_sigmas > types::SolverOutcome::kMaxLastStepSigmas)
        return "its last step still moved the result by " +
               base::fixed(outcome.last_step_sigmas, 1) + " standard deviations";
    return "its cost was still falling by " + base::fixed(100.0 * outcome.last_decrease, 1) +
           " % a step";
}

Finding diverged(const std::string& what) {
    return {
        Severity::Error,
        "diverged",
        "",
        "the reconstruction diverged: " + what,
        "check the calibration of both cameras against the images (divemesh validate DIVE), and "
        "try the option close_loops=false or refine_lenses=false"};
}

// Returns the length of the path within segments: the position of one segment relative to the next
// is a guess.
template <typename Poses>
double path_m(const Poses& poses, const std::vector<bool>& jumps) {
    double length_m = 0.0;
    for (std::size_t i = 1; i < poses.size(); ++i)
        if (!jumps[i])
            length_m +=
                (poses[i].T_world_imu.translation() - poses[i - 1].T_world_imu.translation())
                    .norm();
    return length_m;
}

// Returns for each frame whether the motion to it was not measured, or whether it is the first of a
// segment after the first.
std::vector<bool> jumps_of(const types::OptimisedTrack& result) {
    std::vector<bool> jumps;
    for (const types::StampedPose& pose : result.trajectory)
        jumps.push_back(types::is_break(result.breaks_ns, pose.timestamp_ns));
    std::size_t frame = 0;
    for (std::size_t k = 1; k < result.keyframes.size(); ++k) {
        if (result.keyframes[k].segment == result.keyframes[k - 1].segment) continue;
        while (frame < jumps.size() &&
               result.trajectory[frame].timestamp_ns < result.keyframes[k].timestamp_ns)
            ++frame;
        if (frame < jumps.size()) jumps[frame] = true;
    }
    return jumps;
}

}  // namespace

std::vector<Finding> window_findings(const types::TrackStatistics& track) {
    std::vector<Finding> findings;
    const std::string pose = "the refinement of the motion between two frames";
    add_failed(track.pose_solver, pose, findings);
    add_still_moving(track.pose_solver, pose, findings);
    add_failed(track.window_solver, "bundle adjustment of the sliding window", findings);
    return findings;
}

std::vector<Finding> solver_findings(const types::SolverOutcome& outcome,
                                     const std::string& code,
                                     const std::string& what) {
    if (outcome.failed())
        return {{Severity::Warning,
                 code,
                 "",
                 what + " failed: " + outcome.message,
                 "check the calibration and the inertial sensors of the dive"}};
    if (!outcome.still_moving()) return {};
    return {{Severity::Warning,
             code,
             "",
             what + " stopped after " + std::to_string(outcome.num_iterations) +
                 " iterations while " + last_step(outcome) + ": " + outcome.message,
             "compare the result with what is known about the place before it is used"}};
}

std::optional<Finding> divergence(const types::Track& track, const types::OptimisedTrack& result) {
    for (const types::StampedPose& pose : result.trajectory)
        if (!pose.T_world_imu.matrix().allFinite()) return diverged("a pose is not finite");
    const double reprojection_px = result.statistics.check.after.reprojection_rms_px;
    if (!(reprojection_px <= kDiverged_px))
        return diverged("landmarks lie " + base::fixed(reprojection_px, 1) +
                        " px from where they were seen (root mean square)");
    if (result.trajectory.size() != track.odometry.size()) return std::nullopt;
    const std::vector<bool> jumps = jumps_of(result);
    const double final_m = path_m(result.trajectory, jumps);
    const double odometry_m = path_m(track.odometry, jumps);
    if (final_m <= kDivergedPath * odometry_m + kPathSlack_m) return std::nullopt;
    return diverged("the path is " + base::fixed(final_m, 2) +
                    " m long, but the motion from frame to frame adds up to " +
                    base::fixed(odometry_m, 2) + " m");
}

}  // namespace divemesh::pipeline
