#pragma once

#include <filesystem>
#include <vector>

#include "worker/base/observer.hpp"
#include "worker/keyframes/keyframe_store.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::keyframes {

// Writes keyframes.json (poses of the rectified left camera, its focal length, file names) and
// keyframes/NNNNNN.jpg, the images 320 px wide, into `folder`. Calls `progress` every few images
// with the fraction done, 0 to 1.
void write_keyframe_images(const std::filesystem::path& folder,
                           const types::RectifiedRig& rig,
                           const std::vector<types::Keyframe>& keyframes,
                           const KeyframeStore& store,
                           int num_threads,
                           const base::ProgressCallback& progress);

}  // namespace divemesh::keyframes
