#pragma once

#include <vector>

#include "worker/loops/drift_model.hpp"
#include "worker/loops/loop.hpp"

namespace divemesh::worker {

// Pose graph: keyframes moved so that the loops close, the correction spread along the track by how
// far it may have drifted where. The first keyframe stays. Landmarks go with the keyframe that saw
// them first.
void optimise_pose_graph(const std::vector<Loop>& loops,
                         const DriftModel& drift,
                         std::vector<Keyframe>& keyframes,
                         std::vector<Landmark>& landmarks);

}  // namespace divemesh::worker
