#include "worker/keyframe_writer.hpp"

namespace divemesh::worker {

KeyframeWriter::KeyframeWriter(const RectifiedRig& rig,
                               const ReconstructionOptions& options,
                               const KeyframeStore& store,
                               Workers& workers)
    : match_(options.surface), stereo_(rig, options), store_(store), background_(workers) {}

void KeyframeWriter::write(const RectifiedFrame& frame, const DepthMap& depth) {
    background_.run([this, frame, depth] {
        const bool missing = match_ && depth.disparity_px.empty();
        store_.write(frame.index, {frame.left_color, missing ? stereo_.match(frame) : depth});
    });
}

}  // namespace divemesh::worker
