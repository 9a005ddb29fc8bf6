#pragma once

#include <vector>

#include "worker/base/parallel.hpp"
#include "worker/keyframes/keyframe_images.hpp"
#include "worker/texture/face_candidates.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/mesh.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::texture {

// The candidates of each triangle, and the keyframes that give none.
struct CollectedViews {
    FaceCandidates candidates;
    std::vector<int> lost_frames;  // frame indices of the keyframes whose images cannot be read
};

// Returns the keyframes that show all of a triangle from the front with nothing before it. Each
// image is read once; the memory does not grow with the number of keyframes.
CollectedViews collect_views(const types::Mesh& mesh,
                             const types::RectifiedRig& rig,
                             const std::vector<types::Keyframe>& keyframes,
                             const keyframes::ReadImage& read_image,
                             int num_threads,
                             const base::ProgressShare& progress);

}  // namespace divemesh::texture
