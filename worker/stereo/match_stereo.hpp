#pragma once

#include <memory>
#include <string>

#include "worker/types/keyframe.hpp"

namespace divemesh::stereo {

// Step 1: the dense stereo matcher. Its methods are block, sgm and opencv_sgbm. All give sub-pixel
// disparities with a standard deviation and leave pixels without texture unknown. With two scales
// sgm also matches the images at half their size, see combine_scales(). Images of more than 832 px
// it matches by tiles in any case, within what half the size sees there, see search_tiles().
class StereoMatcher {
public:
    StereoMatcher(const std::string& method, int num_disparities_px, int num_scales = 1);
    ~StereoMatcher();
    StereoMatcher(const StereoMatcher&) = delete;
    StereoMatcher& operator=(const StereoMatcher&) = delete;

    types::DepthMap match(const types::RectifiedFrame& frame);
    // The same; sgm searches within `range`, widened where a survey at a quarter of the size finds
    // disparities beyond: in large images and with two scales also beyond the matcher's own
    // number, see types::max_disparities_px().
    types::DepthMap match(const types::RectifiedFrame& frame, const types::DisparityRange& range);

private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

}  // namespace divemesh::stereo
