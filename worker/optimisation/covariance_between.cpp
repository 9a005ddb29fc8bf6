#include "worker/optimisation/covariance_between.hpp"

#include <algorithm>

namespace divemesh::optimisation {

types::PoseCovariance covariance_between(const types::CovarianceTrack& keyframes,
                                         std::int64_t timestamp_ns) {
    const auto after =
        std::lower_bound(keyframes.begin(),
                         keyframes.end(),
                         timestamp_ns,
                         [](const types::PoseCovariance& keyframe, std::int64_t time) {
                             return keyframe.timestamp_ns < time;
                         });
    types::PoseCovariance at = after == keyframes.end() ? keyframes.back() : *after;
    if (after != keyframes.begin() && after != keyframes.end()) {
        const types::PoseCovariance& before = *(after - 1);
        const double share = static_cast<double>(timestamp_ns - before.timestamp_ns) /
                             static_cast<double>(after->timestamp_ns - before.timestamp_ns);
        at.position_m2 = (1.0 - share) * before.position_m2 + share * after->position_m2;
        at.rotation_rad2 = (1.0 - share) * before.rotation_rad2 + share * after->rotation_rad2;
    }
    at.timestamp_ns = timestamp_ns;
    return at;
}

}  // namespace divemesh::optimisation
