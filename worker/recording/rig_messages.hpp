#pragma once

#include <optional>
#include <string>

#include "worker/recording/choose_topics.hpp"
#include "worker/recording/frame_tree.hpp"
#include "worker/recording/message_log.hpp"

namespace divemesh::recording {

// What the messages of a recording say of its rig.
struct RigMessages {
    std::optional<CameraInfo> left_info;
    std::optional<CameraInfo> right_info;
    std::string left_frame;  // that images name; "": none is stated
    std::string right_frame;
    std::string imu_frame;
    FrameTree frames;
};

// Reads a recording until all is found that the chosen topics can say of the rig. A message that
// cannot be read is left out with a warning.
RigMessages read_rig_messages(MessageLog& log,
                              const ChosenTopics& chosen,
                              dive::FindingLog& findings);

// Where the sensors of a rig are, as far as its frames say. Cameras are those of raw images.
struct RigPoses {
    std::optional<Eigen::Isometry3d> T_cam0_cam1;  // nullopt also where both name one frame
    std::optional<Eigen::Isometry3d> T_imu_cam0;
};

// Returns the poses that tf_static gives. Frames of sensors that it does not relate, or that it
// puts absurdly far apart, are a warning.
RigPoses poses_of_frames(const RigMessages& messages, dive::FindingLog& findings);

}  // namespace divemesh::recording
