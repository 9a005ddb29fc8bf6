#pragma once

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>
#include <optional>

#include "worker/features/align_patch.hpp"
#include "worker/features/plane_warp.hpp"
#include "worker/types/feature.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::features {

// How a feature looked when it was first or anew seen, and from where: so that it can be shown as
// it must look from where the camera is now, its surface taken for a plane.
class ReferencePatch {
public:
    // `feature` as `picture`, CV_8UC1, shows it.
    ReferencePatch(const types::RectifiedRig& rig,
                   const cv::Mat& image,
                   const types::Feature& feature);
    // Seen anew; the surface leans as it did.
    ReferencePatch(const types::RectifiedRig& rig,
                   const cv::Mat& image,
                   const types::Feature& feature,
                   const ReferencePatch& before);

    // The camera has moved.
    void move(const Eigen::Isometry3d& T_current_previous) {
        T_current_reference_ = T_current_previous * T_current_reference_;
    }
    // From where the camera is after a further motion. Nothing when it would be distorted too much,
    // or has no contrast.
    std::optional<Patch> warp_to_current(const types::RectifiedRig& rig,
                                         const Eigen::Isometry3d& T_current_previous) const;

private:
    cv::Mat surroundings_;
    Eigen::Vector2d centre_px_;                   // in them
    std::optional<Eigen::Vector3d> p_reference_;  // nothing: its depth is not known
    Plane plane_reference_ = Plane::Zero();       // with it
    Eigen::Isometry3d T_current_reference_ = Eigen::Isometry3d::Identity();
};

}  // namespace divemesh::features
