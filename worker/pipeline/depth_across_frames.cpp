#include "worker/pipeline/depth_across_frames.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "worker/fusion/depth_view.hpp"
#include "worker/pipeline/neighbour_frames.hpp"
#include "worker/stereo/fill_from_views.hpp"
#include "worker/stereo/refine_from_views.hpp"

namespace divemesh::pipeline {
namespace {

constexpr std::size_t kNumImages = 24;  // kept in memory; neighbours are mostly nearer

}  // namespace

DepthAcrossFrames::DepthAcrossFrames(const types::RectifiedRig& rig,
                                     const std::vector<types::Keyframe>& frames,
                                     const keyframes::KeyframeStore& store,
                                     const std::string& across_frames,
                                     double depth_m)
    : rig_(rig),
      frames_(frames),
      refines_(across_frames != "off"),
      fills_(across_frames == "fill"),
      to_fill_(fills_ ? frames_apart(frames, depth_m) : std::vector<std::size_t>{}),
      lefts_([&store](int frame_index) { return store.left_in_color(frame_index); }, kNumImages) {}

void DepthAcrossFrames::improve(std::size_t frame, types::KeyframeImages& images) {
    const float disparity_px = fusion::median_disparity_px(images.depth);
    if (!refines_ || disparity_px <= 0.0F) return;
    std::vector<stereo::NeighbourView> neighbours;
    for (const std::size_t other : neighbour_frames(frames_, frame, rig_.depth_m(disparity_px)))
        neighbours.push_back({lefts_.grey(frames_[other].frame_index),
                              frames_[other].T_world_cam.inverse() * frames_[frame].T_world_cam});
    cv::Mat left;
    cv::cvtColor(images.left_color, left, cv::COLOR_BGR2GRAY);
    const auto density = fills_ ? stereo::Density::EveryPixel : stereo::Density::Grid;
    stereo::refine_from_views(rig_, left, neighbours, density, images.depth);
    if (std::binary_search(to_fill_.begin(), to_fill_.end(), frame))
        stereo::fill_from_views(rig_, left, neighbours, images.depth);
}

}  // namespace divemesh::pipeline
