#include "worker/pipeline/depth_view_prefetcher.hpp"

#include <algorithm>
#include <utility>

namespace divemesh::pipeline {
namespace {

constexpr int kStep_px = 4;  // of the neighbours' disparities

}  // namespace

DepthViewPrefetcher::DepthViewPrefetcher(const types::RectifiedRig& rig,
                                         VoxelAt voxel_at,
                                         const std::vector<types::Keyframe>& frames,
                                         const keyframes::KeyframeStore& store,
                                         Improve improve,
                                         base::TaskPool& task_pool)
    : rig_(rig),
      voxel_at_(std::move(voxel_at)),
      frames_(frames),
      store_(store),
      improve_(std::move(improve)) {
    for (auto& lane : lanes_) fetch(lane.emplace(task_pool));
}

std::shared_ptr<const fusion::DepthView> DepthViewPrefetcher::next() {
    Lane& lane = *lanes_[num_taken_++ % kNumLanes];
    lane.task.wait();
    auto view = std::exchange(lane.view, nullptr);
    fetch(lane);
    return view;
}

// Returns the frames before and after a frame, with what they measured.
std::vector<fusion::OtherFrame> DepthViewPrefetcher::neighbours_of(std::size_t frame) const {
    const std::size_t begin = frame - std::min(frame, kNeighbours);
    const std::size_t end = std::min(frames_.size(), frame + kNeighbours + 1);
    std::vector<fusion::OtherFrame> neighbours;
    for (std::size_t other = begin; other < end; ++other)
        if (other != frame && frames_[other].segment == frames_[frame].segment)
            neighbours.push_back({frames_[other].T_world_cam.inverse() * frames_[frame].T_world_cam,
                                  store_.read_disparities(frames_[other].frame_index, kStep_px),
                                  kStep_px});
    return neighbours;
}

void DepthViewPrefetcher::fetch(Lane& lane) {
    if (num_fetched_ == frames_.size()) return;
    lane.task.run([this, &lane, frame = num_fetched_++] {
        types::KeyframeImages images = store_.read(frames_[frame].frame_index);
        improve_(frame, images);
        const float disparity_px = fusion::median_disparity_px(images.depth);
        const fusion::Sampling sampling =
            disparity_px > 0.0F
                ? fusion::choose_sampling(rig_, images.depth, voxel_at_(rig_.depth_m(disparity_px)))
                : fusion::Sampling::Full;
        auto view = std::make_shared<fusion::DepthView>(rig_, images, sampling);
        fusion::mark_unshared(neighbours_of(frame), *view);
        lane.view = std::move(view);
    });
}

}  // namespace divemesh::pipeline
