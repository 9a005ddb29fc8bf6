#pragma once

#include <optional>
#include <vector>

#include "schemas/finding.hpp"
#include "worker/dive/dive.hpp"
#include "worker/evaluation/covariance_check.hpp"
#include "worker/evaluation/known_distances.hpp"
#include "worker/evaluation/surface_error.hpp"
#include "worker/evaluation/trajectory_error.hpp"
#include "worker/types/breaks.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::evaluation {

struct EvaluationInput {
    const types::Rig& rig;
    const types::Trajectory& trajectory;  // final
    const types::Trajectory& causal;
    const types::CovarianceTrack& covariances;  // of the final trajectory; empty: unknown
    const std::vector<types::Keyframe>& keyframes;
    const types::Breaks& breaks_ns;         // of the final trajectory
    const types::Mesh* mesh;                // null: no surface was requested
    const types::Trajectory& ground_truth;  // empty: no ground truth
    const std::vector<dive::KnownDistance>& known_distances;
    const std::optional<types::Mesh>& reference;  // in the ground truth's world
    int num_threads = 0;
    double scale_sigma = types::kCalibrationSigma;  // of the final trajectory
    double readout_time_s = 0.0;                    // of a rolling shutter
    double contradiction_sigma = 0.0;               // as in KnownPath
    const types::Mesh* scene = nullptr;             // as in SurfaceErrorInput
};

// The result compared with the ground truth that the dive contains; parts without ground truth are
// nullopt. Ground truth that does not fit (such as another time) is a finding, not an exception, so
// that the reconstruction is kept.
struct Evaluation {
    std::optional<TrajectoryError> trajectory;
    std::optional<TrajectoryError> causal;
    std::optional<CovarianceCheck> covariance;
    std::optional<SurfaceError> surface;
    std::optional<KnownDistanceErrors> known_distances;
    std::vector<Finding> findings;
};

// Compares a reconstruction with all ground truth of its dive.
Evaluation evaluate_reconstruction(const EvaluationInput& input);

}  // namespace divemesh::evaluation
