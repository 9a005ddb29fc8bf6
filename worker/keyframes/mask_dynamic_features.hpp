#pragma once

#include "worker/types/feature.hpp"
#include "worker/types/keyframe.hpp"

namespace divemesh::keyframes {

// Removes from the depth the surface components under dynamic features that have no static feature
// on them. Static features are those of `scene` that are not in `dynamic`.
void mask_dynamic_features(const types::Features& dynamic,
                           const types::Features& scene,
                           types::DepthMap& depth);

}  // namespace divemesh::keyframes
