#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "worker/pipeline/observe_frame.hpp"
#include "worker/pipeline/tracking_state.hpp"
#include "worker/types/keyframe.hpp"

namespace divemesh::pipeline {

// Registers a frame by descriptors where its features were not found from the predicted motion: to
// the previous frame, or to one of the last keyframes.
class Recovery {
public:
    explicit Recovery(TrackingState& state) : state_(state) {}

    // Returns the observation that explains the frame best, `predicted` if there is no better one.
    // Discards a motion that chance explains. A frame that is recognised corrects the previous pose
    // and features.
    Observed recover(const types::RectifiedFrame& frame,
                     const PredictedMotion& prediction,
                     Observed predicted);

private:
    // Finds the features again from the motion by descriptors since the previous frame.
    std::optional<Observed> follow_wide(const types::RectifiedFrame& frame,
                                        const PredictedMotion& prediction);
    // Finds the features of a keyframe again.
    std::optional<Observed> recognise(const types::RectifiedFrame& frame,
                                      const PredictedMotion& prediction);
    void go_back_to(const Eigen::Isometry3d& T_world_keyframe, const types::Features& in_keyframe);

    TrackingState& state_;
};

}  // namespace divemesh::pipeline
