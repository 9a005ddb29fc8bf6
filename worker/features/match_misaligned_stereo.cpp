#include "worker/features/match_misaligned_stereo.hpp"

#include <cmath>

namespace divemesh::features {
namespace {

constexpr float kMaxRowShare = 0.04F;         // of the height: more than a degree
constexpr float kMinDisparityShare = -0.05F;  // of the width
constexpr float kMaxDisparityShare = 0.4F;

}  // namespace

DescribedPair describe_pair(const types::RectifiedFrame& frame) {
    return {describe_image(frame.left), describe_image(frame.right)};
}

std::vector<IndexPair> match_misaligned_keypoints(const DescribedPair& pair) {
    const auto width = static_cast<float>(pair.left.described.cols);
    const auto height = static_cast<float>(pair.left.described.rows);
    const auto may_match = [&](const DescribedKeypoint& left, const DescribedKeypoint& right) {
        const float disparity = left.u_px - right.u_px;
        return std::abs(left.v_px - right.v_px) <= kMaxRowShare * height &&
               disparity >= kMinDisparityShare * width && disparity <= kMaxDisparityShare * width;
    };
    return mutual_nearest(pair.left.keypoints, pair.right.keypoints, may_match);
}

types::StereoMatches match_misaligned_stereo(const types::RectifiedFrame& frame) {
    const DescribedPair pair = describe_pair(frame);
    types::StereoMatches matches;
    for (const auto& [left, right] : match_misaligned_keypoints(pair)) {
        if (!frame.shows_scene(pair.left.full_px(left))) continue;
        if (const auto found = align_keypoint(pair.left, left, pair.right, right))
            matches.push_back({frame.index, pair.left.full_px(left), *found});
    }
    return matches;
}

}  // namespace divemesh::features
