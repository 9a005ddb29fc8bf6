#pragma once

#include <cstdint>

#include "worker/features/track_features.hpp"
#include "worker/imu/inertial_prior.hpp"
#include "worker/odometry/register_points.hpp"
#include "worker/odometry/with_depth_at_both_times.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/rectified_rig.hpp"

// What happens to features between the steps of one frame and the next.
namespace divemesh::odometry {

// Of this frame's random numbers, whatever was drawn before.
std::uint64_t seed_of(std::int64_t seed, const types::RectifiedFrame& frame);

// T_world_cam where the dive begins: the body at the origin, gravity down.
Eigen::Isometry3d first_pose(const imu::InertialPrior& inertial,
                             const types::RectifiedRig& rig,
                             std::int64_t timestamp_ns);

// The tracks without what moves by itself: fish and snow.
types::Features without_dynamic_features(const types::Features& tracks,
                                         const PointPairs& pairs,
                                         const Registration& motion);

// Those that went with the camera's motion, as they are now.
types::Features static_features(const Registration& motion);

// Those that the tracker had lost and finds again now that the motion is known.
void add_lost_features(const types::RectifiedFrame& frame,
                       const Eigen::Isometry3d& T_current_previous,
                       int num_disparities_px,
                       features::FeatureTracker& tracker,
                       types::Features& features);

// Where the picture has lost its features, new ones with their disparity and its slope.
void add_new_features(const types::RectifiedRig& rig,
                      const types::RectifiedFrame& frame,
                      const types::DepthMap& depth,
                      int num_disparities_px,
                      features::FeatureTracker& tracker,
                      types::Features& features);

// What the gyroscope read while vision alone saw the camera turn.
void learn_bias(imu::InertialPrior& inertial,
                const types::RectifiedRig& rig,
                const Registration& vision,
                std::int64_t before_ns,
                std::int64_t now_ns);

}  // namespace divemesh::odometry
