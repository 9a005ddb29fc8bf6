#pragma once

#include <functional>

#include "worker/background.hpp"
#include "worker/keyframe_store.hpp"
#include "worker/steps/match_stereo.hpp"

namespace divemesh::worker {

// Puts what later stages will ask for of a frame into the store, beside the caller: the grey
// picture of a keyframe, to close loops with; picture and dense depth, to make the surface. At most
// one frame waits.
class KeyframeWriter {
public:
    // The left picture of a frame, rectified; called on another thread.
    using LeftInColor = std::function<cv::Mat(int frame_index)>;

    KeyframeWriter(const RectifiedRig& rig,
                   const ReconstructionOptions& options,
                   LeftInColor left_in_color,
                   const KeyframeStore& store,
                   Workers& workers);

    // `depth`: empty when the caller had no need of it; it is matched here when a surface is asked
    // for. Throws what the frame before has thrown.
    void write(const RectifiedFrame& frame, const DepthMap& depth, bool is_keyframe);
    // Every frame is in the store then.
    void finish() { background_.wait(); }

private:
    bool loops_;
    bool surface_;
    LeftInColor left_in_color_;
    StereoMatcher stereo_;
    const KeyframeStore& store_;
    Background background_;
};

}  // namespace divemesh::worker
