#pragma once

#include <vector>

#include "worker/loops/drift_model.hpp"
#include "worker/loops/loop.hpp"
#include "worker/types/solver_outcome.hpp"

namespace divemesh::loops {

// Pose graph: moves the keyframes so that the loops close, with the correction distributed along
// the track according to its drift. The first keyframe stays. Landmarks move with the keyframe that
// observed them first. If the solver fails, keyframes and landmarks stay as they are. Returns how
// the solver ended.
types::SolverOutcome optimise_pose_graph(const std::vector<Loop>& loops,
                                         const DriftModel& drift,
                                         std::vector<types::Keyframe>& keyframes,
                                         std::vector<types::Landmark>& landmarks,
                                         int max_num_iterations = 30);

}  // namespace divemesh::loops
