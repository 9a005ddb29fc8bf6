#pragma once

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>
#include <optional>

#include "worker/features/align_patch.hpp"
#include "worker/features/plane_warp.hpp"
#include "worker/types/feature.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::features {

// The appearance of a feature when it was last taken as reference, with the camera's pose then, so
// that it can be warped to the current frame. Its surface is assumed to be a plane.
class ReferencePatch {
public:
    // Takes `feature` as it appears in `image`, CV_8UC1.
    ReferencePatch(const types::RectifiedRig& rig,
                   const cv::Mat& image,
                   const types::Feature& feature);
    // Takes a new reference of a feature; the surface keeps the slant of `before`.
    ReferencePatch(const types::RectifiedRig& rig,
                   const cv::Mat& image,
                   const types::Feature& feature,
                   const ReferencePatch& before);

    // Updates the pose of the current camera.
    void move(const Eigen::Isometry3d& T_current_previous) {
        T_current_reference_ = T_current_previous * T_current_reference_;
    }
    // Returns d pixel(reference) / d pixel(current) after a further motion; nullopt if the depth is
    // unknown or the patch would be distorted too much.
    std::optional<Eigen::Matrix2d> warp(const types::RectifiedRig& rig,
                                        const Eigen::Isometry3d& T_current_previous) const;
    // Returns the patch as the camera sees it after a further motion; nullopt if it would be
    // distorted too much or has no contrast.
    std::optional<Patch> warp_to_current(const types::RectifiedRig& rig,
                                         const Eigen::Isometry3d& T_current_previous) const;

private:
    cv::Mat surroundings_;
    Eigen::Vector2d centre_px_;                   // in the surroundings
    std::optional<Eigen::Vector3d> p_reference_;  // nullopt: its depth is unknown
    Plane plane_reference_ = Plane::Zero();       // valid with p_reference_
    Eigen::Isometry3d T_current_reference_ = Eigen::Isometry3d::Identity();
};

}  // namespace divemesh::features
