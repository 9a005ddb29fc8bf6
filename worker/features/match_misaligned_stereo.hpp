#pragma once

#include "worker/features/described_image.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/stereo_match.hpp"

namespace divemesh::features {

// A rectified pair with its keypoints.
struct DescribedPair {
    DescribedImage left;
    DescribedImage right;
};

DescribedPair describe_pair(const types::RectifiedFrame& frame);

// Returns the keypoints that match between the images of a pair whose calibration may be wrong by a
// degree: rows differ by up to 4 % of the height, disparities may be negative.
std::vector<IndexPair> match_misaligned_keypoints(const DescribedPair& pair);

// Returns points found in both images of such a pair, sub-pixel in both directions.
types::StereoMatches match_misaligned_stereo(const types::RectifiedFrame& frame);

}  // namespace divemesh::features
