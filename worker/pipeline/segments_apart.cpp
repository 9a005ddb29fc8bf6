#include "worker/pipeline/segments_apart.hpp"

#include <algorithm>

#include "worker/fusion/voxel_size.hpp"
#include "worker/loops/separate_segments.hpp"

namespace divemesh::pipeline {

double set_segments_apart(const types::RectifiedRig& rig,
                          double median_depth_m,
                          std::vector<types::Keyframe>& keyframes) {
    const bool is_single = std::ranges::all_of(
        keyframes, [](const types::Keyframe& keyframe) { return keyframe.segment == 0; });
    if (is_single) return 0.0;
    const double max_depth_m = fusion::farthest_surface_m(rig, median_depth_m);
    // Frames that are fused between keyframes are less than a median depth away from them.
    loops::separate_segments(rig.range_m(max_depth_m) + median_depth_m, keyframes);
    return max_depth_m;
}

}  // namespace divemesh::pipeline
