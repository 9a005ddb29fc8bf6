#pragma once

#include <memory>

#include "schemas/reconstruction_options.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::stereo {

// Step 1: stereo disparity, dense. Which matcher is an option (block, sgm, opencv_sgbm); all give
// sub-pixel disparity with a standard deviation and leave unknown what has no texture.
class StereoMatcher {
public:
    StereoMatcher(const types::RectifiedRig& rig, const ReconstructionOptions& options);
    ~StereoMatcher();
    StereoMatcher(const StereoMatcher&) = delete;
    StereoMatcher& operator=(const StereoMatcher&) = delete;

    types::DepthMap match(const types::RectifiedFrame& frame);
    // sgm looks within `range`, and where a survey at a quarter of the size shows something beyond.
    types::DepthMap match(const types::RectifiedFrame& frame, const types::DisparityRange& range);

private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

}  // namespace divemesh::stereo
