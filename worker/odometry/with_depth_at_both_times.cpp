#include "worker/odometry/with_depth_at_both_times.hpp"

namespace divemesh::worker {

PointPairs with_depth_at_both_times(const RectifiedRig& rig,
                                    const Features& previous,
                                    const Features& current) {
    PointPairs pairs;
    auto before = previous.begin();
    for (const Feature& feature : current) {  // ids rise in both
        while (before != previous.end() && before->id < feature.id) ++before;
        if (before == previous.end()) break;
        if (before->id != feature.id || !has_depth(*before) || !has_depth(feature)) continue;
        PointPair pair;
        pair.id = feature.id;
        pair.previous_px = measurement_px(*before);
        pair.current_px = measurement_px(feature);
        pair.p_previous = point_cam(rig, *before);
        pair.p_current = point_cam(rig, feature);
        pairs.push_back(pair);
    }
    return pairs;
}

}  // namespace divemesh::worker
