#pragma once

#include "schemas/reconstruction_options.hpp"
#include "worker/features/track_features.hpp"
#include "worker/imu/inertial_prior.hpp"
#include "worker/imu/sensor_watch.hpp"
#include "worker/loops/relocaliser.hpp"
#include "worker/odometry/dynamic_features.hpp"
#include "worker/odometry/known_scene.hpp"
#include "worker/odometry/motion_model.hpp"
#include "worker/pipeline/keyframe_map.hpp"
#include "worker/types/feature.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::pipeline {

// The state of the window tracker between two frames, shared by its steps and its recovery.
struct TrackingState {
    TrackingState(const types::RectifiedRig& the_rig,
                  const types::Recording& recording,
                  const ReconstructionOptions& the_options,
                  const imu::SensorPlan& plan)
        : rig(the_rig),
          options(the_options),
          tracker(rig, options.num_features),
          inertial(recording, options, plan.left_out),
          map(rig, inertial),
          memory(rig, options.close_loops, options.num_disparities_px),
          motion(rig, inertial),
          dynamic_features(rig),
          scene(rig) {}
    TrackingState(const TrackingState&) = delete;
    TrackingState& operator=(const TrackingState&) = delete;

    types::RectifiedRig rig;
    ReconstructionOptions options;
    features::FeatureTracker tracker;
    imu::InertialPrior inertial;
    KeyframeMap map;
    loops::Relocaliser memory;
    odometry::MotionModel motion;
    odometry::DynamicFeatures dynamic_features;
    odometry::KnownScene scene;
    types::Features features;  // static ones, as the last frame had them
};

}  // namespace divemesh::pipeline
