#pragma once

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>
#include <optional>

#include "worker/geometry/rectified_rig.hpp"
#include "worker/steps/align_patch.hpp"
#include "worker/steps/feature.hpp"

namespace divemesh::worker {

// How a feature looked when it was first or anew seen, and from where: so that it can be shown as
// it must look from where the camera is now, its surface taken to face the camera then.
class FirstLook {
public:
    // `feature` as `picture`, CV_8UC1, shows it.
    FirstLook(const RectifiedRig& rig, const cv::Mat& picture, const Feature& feature);

    // The camera has moved.
    void move(const Eigen::Isometry3d& T_current_previous) {
        T_now_then_ = T_current_previous * T_now_then_;
    }
    // Nothing when it would be distorted too much, or has no contrast.
    std::optional<Patch> from_here(const RectifiedRig& rig) const;

private:
    cv::Mat surroundings_;
    Eigen::Vector2d centre_px_;              // in them
    std::optional<Eigen::Vector3d> p_then_;  // nothing: its depth is not known
    Eigen::Isometry3d T_now_then_ = Eigen::Isometry3d::Identity();
};

}  // namespace divemesh::worker
