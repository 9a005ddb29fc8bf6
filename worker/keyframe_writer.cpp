#include "worker/keyframe_writer.hpp"

#include <utility>

namespace divemesh::worker {

KeyframeWriter::KeyframeWriter(const RectifiedRig& rig,
                               const ReconstructionOptions& options,
                               LeftInColor left_in_color,
                               const KeyframeStore& store,
                               Workers& workers)
    : loops_(options.close_loops),
      surface_(options.surface),
      left_in_color_(std::move(left_in_color)),
      stereo_(rig, options),
      store_(store),
      background_(workers) {}

void KeyframeWriter::write(const RectifiedFrame& frame, const DepthMap& depth, bool is_keyframe) {
    background_.run([this, frame, depth, is_keyframe] {
        if (loops_ && is_keyframe) store_.write_left(frame.index, frame.left);
        if (!surface_) return;
        const bool missing = depth.disparity_px.empty();
        store_.write(frame.index,
                     {left_in_color_(frame.index), missing ? stereo_.match(frame) : depth});
    });
}

}  // namespace divemesh::worker
