#pragma once

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "worker/types/feature.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::loops {

// A point that a keyframe has seen: where, and how far.
struct KnownPoint {
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
    Eigen::Vector3d p_cam = Eigen::Vector3d::Zero();
};

// Points of one keyframe found in the picture of another, to a fraction of a pixel: by their
// patches, laid over the picture as the motion between the two lets them appear there, and by all
// of them agreeing on that motion. `T_to_from` is the guess, to some pixels, and comes out refined.
// Pictures CV_8UC1. A feature's id is the index of its point, its disparity unknown. Nothing when
// less than twenty are found, or all in one corner.
std::optional<types::Features> search_by_projection(const types::RectifiedRig& rig,
                                                    const cv::Mat& from,
                                                    const std::vector<KnownPoint>& points,
                                                    const cv::Mat& to,
                                                    Eigen::Isometry3d& T_to_from);

// Brings a guess that is some pixels off in pictures halved `num_halvings` times to some pixels off
// in the pictures themselves. Where the pictures do not agree on a motion it stays as it is.
void refine_coarse_to_fine(const types::RectifiedRig& rig,
                           const cv::Mat& from,
                           const std::vector<KnownPoint>& points,
                           const cv::Mat& to,
                           int num_halvings,
                           Eigen::Isometry3d& T_to_from);

}  // namespace divemesh::loops
