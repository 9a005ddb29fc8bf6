#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "worker/keyframes/keyframe_store.hpp"
#include "worker/pipeline/left_images.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::pipeline {

// Improves the depth of fused frames by the frames around them: refines what the pairs measured,
// and with the option across_frames=fill measures what they could not.
class DepthAcrossFrames {
public:
    // `across_frames` as in the options; `depth_m` is the median depth of the dive. `frames` and
    // `store` must outlive it.
    DepthAcrossFrames(const types::RectifiedRig& rig,
                      const std::vector<types::Keyframe>& frames,
                      const keyframes::KeyframeStore& store,
                      const std::string& across_frames,
                      double depth_m);

    // Improves the depth of the frame at a place in `frames`. Thread-safe.
    void improve(std::size_t frame, types::KeyframeImages& images);

private:
    const types::RectifiedRig rig_;
    const std::vector<types::Keyframe>& frames_;
    const bool refines_;
    const bool fills_;
    const std::vector<std::size_t> to_fill_;  // places in frames_, ascending
    LeftImages lefts_;
};

}  // namespace divemesh::pipeline
