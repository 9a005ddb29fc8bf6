#include "worker/keyframes/keyframe_writer.hpp"

#include <utility>

#include "worker/camera/synchronise_pair.hpp"
#include "worker/keyframes/mask_dynamic_features.hpp"

namespace divemesh::keyframes {

KeyframeWriter::KeyframeWriter(const ReconstructionOptions& options,
                               const KeyframeStore& store,
                               base::TaskPool& task_pool)
    : surface_(options.surface), store_(store) {
    for (auto& lane : lanes_) lane.emplace(options, task_pool);
}

void KeyframeWriter::write(const types::RectifiedFrame& frame,
                           const types::DepthMap& depth,
                           const Seen& seen) {
    go_on({});
    waiting_ = Waiting{frame, depth, seen};
}

void KeyframeWriter::go_on(const types::Features& dynamic) {
    if (!waiting_) return;
    types::Features& all = waiting_->seen.dynamic;
    all.insert(all.end(), dynamic.begin(), dynamic.end());
    // The oldest lane, or the next one if a thread is working on the oldest. This thread then
    // stores the frame that is waiting in the lane itself.
    if (lanes_[next_lane_]->task.is_running()) next_lane_ = (next_lane_ + 1) % kNumLanes;
    Lane& lane = *lanes_[next_lane_];
    next_lane_ = (next_lane_ + 1) % kNumLanes;
    lane.task.run([this, &lane, waiting = *std::exchange(waiting_, std::nullopt)]() mutable {
        store(waiting, lane);
    });
}

void KeyframeWriter::finish() {
    go_on({});
    for (auto& lane : lanes_) lane->task.wait();
}

types::SearchStatistics KeyframeWriter::statistics() const {
    types::SearchStatistics all;
    for (const auto& lane : lanes_) all.add(lane->matched);
    return all;
}

void KeyframeWriter::store(Waiting& waiting, Lane& lane) const {
    const types::RectifiedFrame& frame = waiting.frame;
    if (waiting.seen.view) {
        store_.write_left(frame.index, frame.left);
        store_.write_keypoints(frame.index, *waiting.seen.view);
    }
    if (!surface_) return;
    if (waiting.depth.disparity_px.empty()) {
        waiting.depth = waiting.seen.range ? lane.stereo.match(frame, *waiting.seen.range)
                                           : lane.stereo.match(frame);
        camera::correct_disparities(frame, waiting.depth);
    }
    lane.matched.add(waiting.depth.search);
    mask_dynamic_features(waiting.seen.dynamic, waiting.seen.scene, waiting.depth);
    if (!frame.fixed_pattern.empty()) waiting.depth.disparity_px.setTo(0.0F, frame.fixed_pattern);
    store_.write(frame.index, waiting.depth);
}

}  // namespace divemesh::keyframes
