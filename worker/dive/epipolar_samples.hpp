#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "worker/types/rig.hpp"

namespace divemesh::dive {

// A feature of the left image that was found in the right image and, a little later, in the left
// one again. Pixels are those of the left camera.
struct EpipolarSample {
    Eigen::Vector2d ray = Eigen::Vector2d::Zero();        // in cam0, at z = 1
    Eigen::Vector2d right_ray = Eigen::Vector2d::Zero();  // that of the right camera, likewise
    double inverse_depth_1_m = 0.0;
    double error_px = 0.0;   // signed distance of the right feature from its epipolar line
    double rate_px_s = 0.0;  // how fast that distance falls as the camera moves
    double flow_px_s = 0.0;  // of the left feature, along the baseline
    double speed_m_s = 0.0;  // of the left feature in space, across the line of sight
};

// The samples of one moment, and the number of features searched for.
struct EpipolarMoment {
    std::vector<EpipolarSample> samples;
    std::vector<EpipolarSample>
        without_rate;        // found in the right image alone: rate and flow are 0
    int num_mismatches = 0;  // found in the right image, at no possible depth
    int num_corners = 0;
};

// Follows corners of `left` into `right` and into `later`, the left image `interval_s` later; an
// empty `later` gives samples without rates. Images are 8 bit grey, distorted as recorded.
EpipolarMoment sample_epipolar_errors(const types::Rig& rig,
                                      const cv::Mat& left,
                                      const cv::Mat& right,
                                      const cv::Mat& later,
                                      double interval_s);

}  // namespace divemesh::dive
