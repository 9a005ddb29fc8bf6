#include "worker/loops/separate_segments.hpp"

#include <algorithm>
#include <map>

#include "worker/base/disjoint_sets.hpp"

namespace divemesh::loops {
namespace {

struct Extent {
    double low_m = 1e300;
    double high_m = -1e300;
};

}  // namespace

void number_segments(const DriftModel& drift,
                     const std::vector<Loop>& loops,
                     std::vector<types::Keyframe>& keyframes) {
    base::DisjointSets tied(keyframes.size());
    for (std::size_t k = 1; k < keyframes.size(); ++k)
        if (drift.follows(k)) tied.join(k - 1, k);
    for (const Loop& loop : loops) tied.join(loop.from, loop.to);
    std::map<std::size_t, std::int32_t> number;
    for (std::size_t k = 0; k < keyframes.size(); ++k)
        keyframes[k].segment =
            number.try_emplace(tied.find(k), static_cast<std::int32_t>(number.size()))
                .first->second;
}

void separate_segments(double reach_m, std::vector<types::Keyframe>& keyframes) {
    std::map<std::int32_t, Extent> extents;
    for (const types::Keyframe& keyframe : keyframes) {
        Extent& extent = extents[keyframe.segment];
        extent.low_m = std::min(extent.low_m, keyframe.T_world_cam.translation().x() - reach_m);
        extent.high_m = std::max(extent.high_m, keyframe.T_world_cam.translation().x() + reach_m);
    }
    std::map<std::int32_t, double> shift_m;
    double taken_m = -1e300;
    for (const auto& [segment, extent] : extents) {
        shift_m[segment] = std::max(0.0, taken_m - extent.low_m);
        taken_m = std::max(taken_m, extent.high_m + shift_m[segment]);
    }
    for (types::Keyframe& keyframe : keyframes)
        keyframe.T_world_cam.translation().x() += shift_m[keyframe.segment];
}

}  // namespace divemesh::loops
