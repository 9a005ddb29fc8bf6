#pragma once

#include <filesystem>
#include <vector>

#include "worker/base/observer.hpp"
#include "worker/keyframes/keyframe_store.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::keyframes {

// keyframes.json (poses of the rectified left camera, its focal length, file names) and
// keyframes/NNNNNN.jpg, the pictures 320 px wide, in `folder`. The callback is called every
// few pictures with a fraction from 0 to 1 of this work.
void write_keyframe_images(const std::filesystem::path& folder,
                           const types::RectifiedRig& rig,
                           const std::vector<types::Keyframe>& keyframes,
                           const KeyframeStore& store,
                           int num_threads,
                           const base::ProgressCallback& progress);

}  // namespace divemesh::keyframes
