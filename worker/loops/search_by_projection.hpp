#pragma once

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "worker/types/feature.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::loops {

// A point observed in a keyframe: its pixel and its position in the camera frame, m.
struct KnownPoint {
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
    Eigen::Vector3d p_cam = Eigen::Vector3d::Zero();
};

// Finds points of one keyframe in the image of another, with sub-pixel accuracy: their patches are
// warped by the relative pose, and all must agree on that pose. `T_to_from` is a guess accurate to
// some pixels and is refined. Images are CV_8UC1. A feature's id is the index of its point; its
// disparity is unknown. Returns nullopt if fewer than twenty are found, or all in one corner.
std::optional<types::Features> search_by_projection(const types::RectifiedRig& rig,
                                                    const cv::Mat& from,
                                                    const std::vector<KnownPoint>& points,
                                                    const cv::Mat& to,
                                                    Eigen::Isometry3d& T_to_from);

// Refines a guess that is accurate to some pixels in images halved `num_halvings` times to some
// pixels in the full images. If the images do not agree on a motion, the guess stays as it is.
void refine_coarse_to_fine(const types::RectifiedRig& rig,
                           const cv::Mat& from,
                           const std::vector<KnownPoint>& points,
                           const cv::Mat& to,
                           int num_halvings,
                           Eigen::Isometry3d& T_to_from);

}  // namespace divemesh::loops
