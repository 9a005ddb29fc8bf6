#pragma once

#include <optional>
#include <vector>

#include "schemas/finding.hpp"
#include "worker/dive/dive.hpp"
#include "worker/evaluation/covariance_check.hpp"
#include "worker/evaluation/known_distances.hpp"
#include "worker/evaluation/surface_error.hpp"
#include "worker/evaluation/trajectory_error.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::evaluation {

struct EvaluationInput {
    const types::Rig& rig;
    const types::Trajectory& trajectory;  // final
    const types::Trajectory& causal;
    const types::CovarianceTrack& covariances;  // of the final one; empty: none
    const std::vector<types::Keyframe>& keyframes;
    const types::Mesh* mesh;                // none: no surface was asked for
    const types::Trajectory& ground_truth;  // empty: none
    const std::vector<dive::KnownDistance>& known_distances;
    const std::optional<types::Mesh>& reference;  // in the ground truth's world
    int num_threads = 0;
};

// The result against whatever truth the dive brings. What it does not bring is not there; truth
// that does not fit (another time) is a finding, never an exception: the reconstruction stands.
struct Evaluation {
    std::optional<TrajectoryError> trajectory;
    std::optional<TrajectoryError> causal;
    std::optional<CovarianceCheck> covariance;
    std::optional<SurfaceError> surface;
    std::optional<KnownDistanceErrors> known_distances;
    std::vector<Finding> findings;
};

Evaluation evaluate_reconstruction(const EvaluationInput& input);

}  // namespace divemesh::evaluation
