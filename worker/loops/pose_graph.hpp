#pragma once

#include <vector>

#include "worker/loops/drift_model.hpp"
#include "worker/loops/loop.hpp"
#include "worker/types/solver_outcome.hpp"

namespace divemesh::loops {

// Pose graph: keyframes moved so that the loops close, the correction spread along the track by how
// far it may have drifted where. The first keyframe stays. Landmarks go with the keyframe that saw
// them first. Where the solver fails everything stays where it is.
types::SolverOutcome optimise_pose_graph(const std::vector<Loop>& loops,
                                         const DriftModel& drift,
                                         std::vector<types::Keyframe>& keyframes,
                                         std::vector<types::Landmark>& landmarks);

}  // namespace divemesh::loops
