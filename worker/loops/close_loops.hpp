#pragma once

#include <optional>
#include <vector>

#include "worker/loops/drift_model.hpp"
#include "worker/loops/loop.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/landmark.hpp"
#include "worker/types/loop_statistics.hpp"
#include "worker/types/rectified_rig.hpp"
#include "worker/types/solver_outcome.hpp"
#include "worker/types/track.hpp"

namespace divemesh::loops {

// Adds the reobservations of the loops to the landmarks, for the bundle adjustment of the whole
// dive. If the track has drifted too far for that to converge, a pose graph first moves the
// keyframes closer. Also sets the keyframes' segments. Returns how the solver of the pose graph
// ended; nullopt if no pose graph was needed.
std::optional<types::SolverOutcome> close_loops(const types::RectifiedRig& rig,
                                                const std::vector<Loop>& loops,
                                                const DriftModel& drift,
                                                std::vector<types::Keyframe>& keyframes,
                                                std::vector<types::Landmark>& landmarks);

// Sets in `statistics` the residuals of the loops at the final keyframes.
void add_residuals(const std::vector<Loop>& loops,
                   const std::vector<types::Keyframe>& keyframes,
                   types::LoopStatistics& statistics);

}  // namespace divemesh::loops
