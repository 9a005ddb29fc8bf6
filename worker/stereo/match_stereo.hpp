#pragma once

#include <memory>
#include <string>

#include "worker/types/keyframe.hpp"

namespace divemesh::stereo {

// Step 1: the dense stereo matcher. Its methods are block, sgm and opencv_sgbm. All give sub-pixel
// disparities with a standard deviation and leave pixels without texture unknown.
class StereoMatcher {
public:
    StereoMatcher(const std::string& method, int num_disparities_px);
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
