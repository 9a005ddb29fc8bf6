#pragma once

#include <cstdint>

#include "worker/imu/inertial_prior.hpp"
#include "worker/types/rectified_rig.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/odometry/register_points.hpp"
#include "worker/features/track_features.hpp"
#include "worker/odometry/with_depth_at_both_times.hpp"

// What happens to features between the steps of one frame and the next.
namespace divemesh::worker {

// Of this frame's random numbers, whatever was drawn before.
std::uint64_t seed_of(std::int64_t seed, const RectifiedFrame& frame);

// T_world_cam where the dive begins: the body at the origin, gravity down.
Eigen::Isometry3d first_pose(const InertialPrior& inertial,
                             const RectifiedRig& rig,
                             std::int64_t timestamp_ns);

// The tracks without what moves by itself: fish and snow.
Features without_dynamic_features(const Features& tracks,
                                  const PointPairs& pairs,
                                  const Registration& motion);

// Those that went with the camera's motion, as they are now.
Features static_features(const Registration& motion);

// Those that the tracker had lost and finds again now that the motion is known.
void add_lost_features(const RectifiedFrame& frame,
                       const Eigen::Isometry3d& T_current_previous,
                       int num_disparities_px,
                       FeatureTracker& tracker,
                       Features& features);

// Where the picture has lost its features, new ones with their disparity and its slope.
void add_new_features(const RectifiedRig& rig,
                      const RectifiedFrame& frame,
                      const DepthMap& depth,
                      int num_disparities_px,
                      FeatureTracker& tracker,
                      Features& features);

// What the gyroscope read while vision alone saw the camera turn.
void learn_bias(InertialPrior& inertial,
                const RectifiedRig& rig,
                const Registration& vision,
                std::int64_t before_ns,
                std::int64_t now_ns);

}  // namespace divemesh::worker
