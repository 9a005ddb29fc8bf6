#include "worker/pipeline/depth_view_prefetcher.hpp"

#include <utility>

namespace divemesh::pipeline {

DepthViewPrefetcher::DepthViewPrefetcher(const types::RectifiedRig& rig,
                                         double voxel_m,
                                         const std::vector<types::Keyframe>& frames,
                                         const keyframes::KeyframeStore& store,
                                         base::TaskPool& task_pool)
    : rig_(rig), voxel_m_(voxel_m), frames_(frames), store_(store) {
    for (auto& lane : lanes_) fetch(lane.emplace(task_pool));
}

std::shared_ptr<const fusion::DepthView> DepthViewPrefetcher::next() {
    Lane& lane = *lanes_[num_taken_++ % kNumLanes];
    lane.task.wait();
    auto view = std::exchange(lane.view, nullptr);
    fetch(lane);
    return view;
}

void DepthViewPrefetcher::fetch(Lane& lane) {
    if (num_fetched_ == frames_.size()) return;
    lane.task.run([this, &lane, frame_index = frames_[num_fetched_++].frame_index] {
        const types::KeyframeImages images = store_.read(frame_index);
        const fusion::Sampling sampling = fusion::choose_sampling(rig_, images.depth, voxel_m_);
        lane.view = std::make_shared<const fusion::DepthView>(rig_, images, sampling);
    });
}

}  // namespace divemesh::pipeline
