#pragma once

#include <cstdint>

#include "worker/features/track_features.hpp"
#include "worker/imu/inertial_prior.hpp"
#include "worker/odometry/known_scene.hpp"
#include "worker/odometry/register_points.hpp"
#include "worker/odometry/with_depth_at_both_times.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/rectified_rig.hpp"
#include "worker/types/track.hpp"

// The handling of features between the steps of one frame and the next.
namespace divemesh::odometry {

// Returns the seed of this frame's random numbers, independent of earlier draws.
std::uint64_t seed_of(std::int64_t seed, const types::RectifiedFrame& frame);

// Returns T_world_cam at the start of the dive: the body at the origin, gravity down.
Eigen::Isometry3d first_pose(const imu::InertialPrior& inertial,
                             const types::RectifiedRig& rig,
                             std::int64_t timestamp_ns);

// Returns the tracks without dynamic features: fish and marine snow.
types::Features without_dynamic_features(const types::Features& tracks,
                                         const PointPairs& pairs,
                                         const Registration& motion);

// Returns the inliers of the motion as features at their current positions, or at their previous
// ones.
types::Features static_features(const Registration& motion);
types::Features previous_static_features(const Registration& motion);

std::size_t num_with_depth(const types::Features& features);
// Returns the median disparity of those with depth; 0 if there is none.
double median_disparity_px(const types::Features& features);
types::FrameFeatures feature_counts(const types::Features& features);

// Adds features of the scene that the tracker had lost and finds again once the motion is known.
void add_lost_features(const types::RectifiedFrame& frame,
                       const Eigen::Isometry3d& T_current_previous,
                       int num_disparities_px,
                       const KnownScene& scene,
                       features::FeatureTracker& tracker,
                       types::Features& features);

// Adds new features with disparity and slope where the image has none.
void add_new_features(const types::RectifiedRig& rig,
                      const types::RectifiedFrame& frame,
                      const types::DepthMap& depth,
                      int num_disparities_px,
                      features::FeatureTracker& tracker,
                      types::Features& features);

// Updates the gyroscope bias from the rotation that vision alone measured.
void learn_bias(imu::InertialPrior& inertial,
                const types::RectifiedRig& rig,
                const Registration& vision,
                std::int64_t before_ns,
                std::int64_t now_ns);

}  // namespace divemesh::odometry
