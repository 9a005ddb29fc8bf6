#include "worker/odometry/with_depth_at_both_times.hpp"

namespace divemesh::odometry {

PointPairs with_depth_at_both_times(const types::RectifiedRig& rig,
                                    const types::Features& previous,
                                    const types::Features& current) {
    PointPairs pairs;
    auto before = previous.begin();
    for (const types::Feature& feature : current) {  // ids ascend in both
        while (before != previous.end() && before->id < feature.id) ++before;
        if (before == previous.end()) break;
        if (before->id != feature.id || !types::has_depth(*before) || !types::has_depth(feature))
            continue;
        PointPair pair;
        pair.id = feature.id;
        pair.previous_px = types::measurement_px(*before);
        pair.current_px = types::measurement_px(feature);
        pair.p_previous = types::point_cam(rig, *before);
        pair.p_current = types::point_cam(rig, feature);
        pairs.push_back(pair);
    }
    return pairs;
}

}  // namespace divemesh::odometry
