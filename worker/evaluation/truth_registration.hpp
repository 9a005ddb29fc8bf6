#pragma once

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "schemas/truth_options.hpp"
#include "worker/evaluation/trajectory_error_options.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/solver_outcome.hpp"

namespace divemesh::evaluation {

// The relation of a ground truth with another body and clock to the estimate. Standard deviations
// are of the solved quantities: the larger of the one from the residuals, corrected for their
// autocorrelation, and the one from the scatter of the gradients over tenths of the path.
struct TruthRegistration {
    Eigen::Isometry3d T_body_marker = Eigen::Isometry3d::Identity();
    double time_offset_s = 0.0;  // the truth's clock minus the dive's
    std::optional<Eigen::Vector3d> lever_arm_sigma_m;
    std::optional<double> rotation_sigma_deg;  // of the marker's axes; nullopt: not solved
    std::optional<double> time_offset_sigma_s;
    bool has_orientation = true;  // false: the truth has only positions
    std::int64_t num_poses = 0;   // used by the solution; 0: no solution was computed
    double residual_rms_m = 0.0;
    types::SolverOutcome outcome;  // costs: squared residuals at the first and last step, m^2
};

// Solves for what the options request, by least squares over positions together with the SE(3)
// between the worlds (Gauss-Newton). The offset is initialised where rates of rotation, or speeds
// if the truth has no rotations, correlate best, over all offsets at which half of the estimate
// lies in the truth. Throws Error{BadData} if the motion does not determine a requested quantity: a
// lever arm if the rig rotated about fewer than two axes, an offset if its velocity did not change,
// either if Gauss-Newton stops at its limit while the residuals are still falling.
TruthRegistration register_truth(const types::Trajectory& estimate,
                                 const types::Trajectory& truth,
                                 const TruthOptions& options);

// A ground truth on the estimate's clock, with the options that pair both. A truth without
// orientations gets those of the estimate, aligned with the truth's world.
struct RegisteredTruth {
    TruthRegistration registration;
    types::Trajectory poses;
    TrajectoryErrorOptions options;
};

// Registers the truth and moves it to the estimate's clock. Throws as register_truth() does.
RegisteredTruth registered_truth(const types::Trajectory& estimate,
                                 types::Trajectory truth,
                                 const TruthOptions& options);

// Returns "truth" of the report: lever arm and offset, and how they were determined.
nlohmann::json to_metrics(const TruthRegistration& registration, const TruthOptions& options);

// Returns the metrics of a trajectory without those that need the truth's orientations.
nlohmann::json without_rotations(nlohmann::json trajectory);

}  // namespace divemesh::evaluation
