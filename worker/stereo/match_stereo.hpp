#pragma once

#include <memory>

#include "schemas/reconstruction_options.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::stereo {

// Step 1: the dense stereo matcher. The method is an option (block, sgm, opencv_sgbm). All give
// sub-pixel disparities with a standard deviation and leave pixels without texture unknown.
class StereoMatcher {
public:
    StereoMatcher(const types::RectifiedRig& rig, const ReconstructionOptions& options);
    ~StereoMatcher();
    StereoMatcher(const StereoMatcher&) = delete;
    StereoMatcher& operator=(const StereoMatcher&) = delete;

    types::DepthMap match(const types::RectifiedFrame& frame);
    // The same; sgm searches within `range`, widened where a survey at a quarter of the size finds
    // disparities beyond.
    types::DepthMap match(const types::RectifiedFrame& frame, const types::DisparityRange& range);

private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

}  // namespace divemesh::stereo
