#pragma once

#include <Eigen/Core>

#include "worker/features/feature_shift.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::keyframes {

// A frame's features, where its camera was, and how near the scene.
struct MappingView {
    const types::Features& features;
    Eigen::Vector3d p_world_cam;
    double median_disparity_px = 0.0;
};

// The rule for which frames besides the keyframes are matched densely and fused. More observations
// of a surface average the noise of its depth and confirm it. Neighbouring frames share much of
// their error. So a frame is taken only if the image has moved, or if the camera has moved as far
// as would shift the image sideways by that much. The second rule serves cameras that swim forward
// or orbit.
class MappingRule {
public:
    // `step` is the min movement as a fraction of the image width; 0: keyframes only.
    MappingRule(const types::RectifiedRig& rig, double step)
        : step_px_(step * rig.width_px), baseline_m_(rig.baseline_m) {}

    bool due(const MappingView& view) const {
        if (step_px_ <= 0.0) return false;
        const double moved_m = (view.p_world_cam - p_world_cam_).norm();
        return moved_m * view.median_disparity_px >= step_px_ * baseline_m_ ||
               shift_.since(view.features).median_px >= step_px_;
    }
    void taken(const MappingView& view) {
        shift_.start(view.features);
        p_world_cam_ = view.p_world_cam;
    }

private:
    double step_px_;
    double baseline_m_;
    features::FeatureShift shift_;
    Eigen::Vector3d p_world_cam_ = Eigen::Vector3d::Zero();
};

}  // namespace divemesh::keyframes
