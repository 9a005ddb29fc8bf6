#pragma once

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "schemas/truth_options.hpp"
#include "worker/evaluation/trajectory_error_options.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::evaluation {

// How a truth of another body and clock lies to the estimate. Standard deviations are of what was
// solved: the larger of what residuals say when they are no more independent than their
// autocorrelation lets them be, and of how the gradients of tenths of the path scatter.
struct TruthRegistration {
    Eigen::Isometry3d T_body_marker = Eigen::Isometry3d::Identity();
    double time_offset_s = 0.0;  // the truth's clock minus the dive's
    std::optional<Eigen::Vector3d> lever_arm_sigma_m;
    std::optional<double> rotation_sigma_deg;  // of the marker's axes; nothing: not solved
    std::optional<double> time_offset_sigma_s;
    bool has_orientation = true;  // false: the truth knows positions alone
    std::int64_t num_poses = 0;   // that a solution was found from; 0: nothing was solved
    double residual_rms_m = 0.0;
};

// What the options ask to be solved, by least squares over positions together with the SE(3)
// between the worlds (Gauss-Newton). An offset is looked for first where rates of rotation, or
// speeds where the truth has no rotations, correlate best (over all offsets at which half of the
// estimate lies in the truth). Throws Error{BadData} where the motion does not fix what is asked
// for: a lever arm when the rig turned about less than two axes, an offset when its velocity did
// not change.
TruthRegistration register_truth(const types::Trajectory& estimate,
                                 const types::Trajectory& truth,
                                 const TruthOptions& options);

// A truth on the estimate's clock, with the options that pair both. Where the truth has no
// orientation it takes the estimate's, laid on the truth's world.
struct RegisteredTruth {
    TruthRegistration registration;
    types::Trajectory poses;
    TrajectoryErrorOptions options;
};
RegisteredTruth registered_truth(const types::Trajectory& estimate,
                                 types::Trajectory truth,
                                 const TruthOptions& options);

// "truth" of the report: lever arm and offset with how they came about.
nlohmann::json to_metrics(const TruthRegistration& registration, const TruthOptions& options);

// The figures of a trajectory without those that need the truth's orientations.
nlohmann::json without_rotations(nlohmann::json trajectory);

}  // namespace divemesh::evaluation
