#include "worker/estimation/pose_covariance.hpp"

#include <algorithm>

namespace divemesh::worker {

CovarianceTrack covariances_at(const CovarianceTrack& keyframes, const Trajectory& frames) {
    CovarianceTrack result;
    if (keyframes.empty()) return result;
    for (const StampedPose& frame : frames) {
        const auto after = std::lower_bound(keyframes.begin(),
                                            keyframes.end(),
                                            frame.timestamp_ns,
                                            [](const PoseCovariance& keyframe, std::int64_t time) {
                                                return keyframe.timestamp_ns < time;
                                            });
        PoseCovariance at = after == keyframes.end() ? keyframes.back() : *after;
        if (after != keyframes.begin() && after != keyframes.end()) {
            const PoseCovariance& before = *(after - 1);
            const double share = static_cast<double>(frame.timestamp_ns - before.timestamp_ns) /
                                 static_cast<double>(after->timestamp_ns - before.timestamp_ns);
            at.position_m2 = (1.0 - share) * before.position_m2 + share * after->position_m2;
            at.rotation_rad2 = (1.0 - share) * before.rotation_rad2 + share * after->rotation_rad2;
        }
        at.timestamp_ns = frame.timestamp_ns;
        result.push_back(at);
    }
    return result;
}

}  // namespace divemesh::worker
