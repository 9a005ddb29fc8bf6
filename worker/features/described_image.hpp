#pragma once

#include <Eigen/Core>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "worker/features/described_keypoints.hpp"

namespace divemesh::features {

// An image with its keypoints. Large images are described at a reduced size, so that the keypoints
// are spread over all of it.
struct DescribedImage {
    cv::Mat full;
    cv::Mat described;   // what the keypoints' pixels refer to
    double scale = 1.0;  // size of its pixels in the full image
    DescribedKeypoints keypoints;

    Eigen::Vector2d keypoint_px(std::size_t index) const {
        return {keypoints[index].u_px, keypoints[index].v_px};
    }
    // Returns the position of a keypoint in the full image.
    Eigen::Vector2d full_px(std::size_t index) const;
};

DescribedImage describe_image(const cv::Mat& image);

struct IndexPair {
    std::size_t a = 0;
    std::size_t b = 0;
};

// Returns the keypoints that are each other's nearest by descriptor and clearly nearer than any
// other place (Lowe 2004), among those that `may_match`. Ordered by a.
std::vector<IndexPair> mutual_nearest(
    const DescribedKeypoints& a,
    const DescribedKeypoints& b,
    const std::function<bool(const DescribedKeypoint& a, const DescribedKeypoint& b)>& may_match);

// Returns where the patch around keypoint `of_a` of image a lies in the full image b, sub-pixel,
// near keypoint `of_b`. The patch is tried with the shapes that slanted surfaces give it.
std::optional<Eigen::Vector2d> align_keypoint(const DescribedImage& a,
                                              std::size_t of_a,
                                              const DescribedImage& b,
                                              std::size_t of_b);

}  // namespace divemesh::features
