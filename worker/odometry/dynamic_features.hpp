#pragma once

#include <Eigen/Geometry>

#include "worker/odometry/register_points.hpp"
#include "worker/types/feature.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::odometry {

// Dynamic features, e.g. on fish and marine snow: they did not follow the camera's motion. They no
// longer contribute to the motion, but tracking continues, so that the depth under them can be
// masked.
class DynamicFeatures {
public:
    explicit DynamicFeatures(const types::RectifiedRig& rig) : rig_(rig) {}

    // Returns the features to track: `scene` and the dynamic ones, ids ascending.
    types::Features with_dynamic(const types::Features& scene) const;
    // Removes the dynamic features from the tracks and stores their current positions.
    void take_dynamic(types::Features& tracks);
    // Drops the dynamic features of the current frame: the motion by which they were tracked was
    // wrong.
    void forget() {
        features_.clear();
        started_.clear();
    }
    // Classifies pairs that are not inliers of the motion as dynamic. Dynamic features that follow
    // the static scene after all are dropped.
    void classify(const PointPairs& pairs, const Registration& motion);

    // Returns the dynamic features as last seen.
    const types::Features& now() const { return features_; }
    // Returns the features newly classified as dynamic, as the previous frame had them.
    const types::Features& before() const { return started_; }

private:
    bool moves_with_scene(const Eigen::Isometry3d& T_current_previous,
                          const types::Feature& feature) const;

    types::RectifiedRig rig_;
    types::Features features_;
    types::Features previous_;  // as the previous frame had them
    types::Features started_;
};

}  // namespace divemesh::odometry
