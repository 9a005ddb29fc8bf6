#pragma once

#include <Eigen/Geometry>

#include "worker/odometry/register_points.hpp"
#include "worker/types/feature.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::odometry {

// What moves by itself, fish and snow: features that did not go with the camera's motion. They tell
// nothing of that motion any more, but are followed on, so that the surface can be kept free of
// what they lie on.
class DynamicFeatures {
public:
    explicit DynamicFeatures(const types::RectifiedRig& rig) : rig_(rig) {}

    // What to track: the features of the scene and these, ids rising.
    types::Features with_dynamic(const types::Features& scene) const;
    // Takes these out of the tracks and keeps where they are now.
    void take_dynamic(types::Features& tracks);
    // Pairs that are not among the inliers of the motion move by themselves from now on; what goes
    // with the scene after all is followed no more.
    void classify(const PointPairs& pairs, const Registration& motion);

    // As last seen.
    const types::Features& now() const { return features_; }
    // Those that were found to move just now, as the frame before had them.
    const types::Features& before() const { return started_; }

private:
    bool moves_with_scene(const Eigen::Isometry3d& T_current_previous,
                          const types::Feature& feature) const;

    types::RectifiedRig rig_;
    types::Features features_;
    types::Features previous_;  // as the frame before had them
    types::Features started_;
};

// Takes out of the depth the patches of surface that lie under moving features and under none of
// the scene: features that went along with the camera, and are not among the moving ones.
void mask_dynamic_features(const types::Features& dynamic,
                           const types::Features& scene,
                           types::DepthMap& depth);

}  // namespace divemesh::odometry
