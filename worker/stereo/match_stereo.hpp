#pragma once

#include <memory>

#include "schemas/reconstruction_options.hpp"
#include "worker/types/rectified_rig.hpp"
#include "worker/types/keyframe.hpp"

namespace divemesh::worker {

// Step 1: stereo disparity, dense. Which matcher is an option (block, sgm, opencv_sgbm); all give
// sub-pixel disparity with a standard deviation and leave unknown what has no texture.
class StereoMatcher {
public:
    StereoMatcher(const RectifiedRig& rig, const ReconstructionOptions& options);
    ~StereoMatcher();
    StereoMatcher(const StereoMatcher&) = delete;
    StereoMatcher& operator=(const StereoMatcher&) = delete;

    DepthMap match(const RectifiedFrame& frame);
    // sgm looks within `range`, and where a survey at a quarter of the size shows something beyond.
    DepthMap match(const RectifiedFrame& frame, const DisparityRange& range);

private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

}  // namespace divemesh::worker
