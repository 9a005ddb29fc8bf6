#include "worker/keyframe_writer.hpp"

#include <utility>

namespace divemesh::worker {

KeyframeWriter::KeyframeWriter(const RectifiedRig& rig,
                               const ReconstructionOptions& options,
                               LeftInColor left_in_color,
                               const KeyframeStore& store,
                               Workers& workers)
    : match_(options.surface),
      left_in_color_(std::move(left_in_color)),
      stereo_(rig, options),
      store_(store),
      background_(workers) {}

void KeyframeWriter::write(const RectifiedFrame& frame, const DepthMap& depth) {
    background_.run([this, frame, depth] {
        const bool missing = match_ && depth.disparity_px.empty();
        store_.write(frame.index,
                     {left_in_color_(frame.index), missing ? stereo_.match(frame) : depth});
    });
}

}  // namespace divemesh::worker
