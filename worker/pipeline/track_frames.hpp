#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "schemas/reconstruction_options.hpp"
#include "worker/base/observer.hpp"
#include "worker/camera/rectifier.hpp"
#include "worker/keyframes/keyframe_store.hpp"
#include "worker/keyframes/keyframe_writer.hpp"
#include "worker/types/feature.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/track.hpp"

namespace divemesh::pipeline {

// The data of a frame for mapping that the keyframe writer needs.
struct FrameToMap {
    types::RectifiedFrame frame;
    types::DepthMap depth;  // empty: the writer matches the frame itself
    keyframes::KeyframeWriter::Seen seen;
};

// A tracker's result for one frame.
struct TrackedFrame {
    Eigen::Isometry3d T_current_previous = Eigen::Isometry3d::Identity();  // by steps 1 to 6
    Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();         // as estimated now
    types::Features dynamic_before;    // newly found dynamic features, as in the previous frame
    std::optional<FrameToMap> to_map;  // nullopt: not mapped
    types::MotionSigma sigma = {};     // of T_current_previous
    bool by_vision = false;            // vision measured T_current_previous
    bool predicted_by_imu = false;     // else: the IMU measured it, with a known velocity
    types::FrameFeatures features = {};
};

// A tracker: steps 1 to 6, one frame at a time.
class FrameTracker {
public:
    virtual ~FrameTracker() = default;

    // Tracks the next frame; frames must come in order.
    virtual TrackedFrame process(const types::RectifiedFrame& frame) = 0;
    // Returns true if the dive has to be tracked again in another way, so that tracking the
    // remaining frames is useless.
    virtual bool must_restart() const { return false; }
    // Moves keyframes, landmarks, the IMU alignment and statistics to the track.
    virtual void move_to(types::Track& track) = 0;
};

// Reads all frames of a recording, rectifies each and passes it to `tracker`, whose rig is that of
// `rectifier`. Writes the frames to map into `store` and reports progress after each frame. Stops
// early if must_restart() is true.
types::Track track_frames(types::Recording& recording,
                          const camera::Rectifier& rectifier,
                          const ReconstructionOptions& options,
                          const keyframes::KeyframeStore& store,
                          FrameTracker& tracker,
                          const base::ProgressCallback& progress);

}  // namespace divemesh::pipeline
