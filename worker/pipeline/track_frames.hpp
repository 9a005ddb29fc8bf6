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

// A frame that is kept for mapping: what the keyframe writer needs of it.
struct FrameToMap {
    types::DepthMap depth;  // empty: the writer matches the frame itself
    keyframes::KeyframeWriter::Seen seen;
};

// What a tracker found out about one frame.
struct TrackedFrame {
    Eigen::Isometry3d T_current_previous = Eigen::Isometry3d::Identity();  // by steps 1 to 6
    Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();         // as known now
    types::Features moving_before;     // features of the frame before that were found to move
    std::optional<FrameToMap> to_map;  // nullopt: the frame is not kept
};

// Steps 1 to 6, one frame at a time.
class FrameTracker {
public:
    virtual ~FrameTracker() = default;

    // Frames come in order.
    virtual TrackedFrame process(const types::RectifiedFrame& frame) = 0;
    // Hands over keyframes, landmarks, the alignment of the inertial unit and statistics.
    virtual void move_to(types::Track& track) = 0;
};

// Reads all frames of a recording and has each of them processed by `tracker`, whose rig is that of
// `rectifier`. Writes the frames to map into `store` and reports progress after each frame.
types::Track track_frames(types::Recording& recording,
                          const camera::Rectifier& rectifier,
                          const ReconstructionOptions& options,
                          const keyframes::KeyframeStore& store,
                          FrameTracker& tracker,
                          const base::ProgressCallback& progress);

}  // namespace divemesh::pipeline
