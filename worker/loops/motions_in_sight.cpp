#include "worker/loops/motions_in_sight.hpp"

#include <algorithm>
#include <cmath>

#include "worker/optimisation/follow_keyframes.hpp"
#include "worker/optimisation/motion_variances.hpp"

namespace divemesh::loops {
namespace {

bool all_by_vision(const types::Track& track, std::size_t from, std::size_t to) {
    const auto first = track.motions.begin() + static_cast<std::ptrdiff_t>(from) + 1;
    const auto end = track.motions.begin() + static_cast<std::ptrdiff_t>(to) + 1;
    return std::all_of(first, end, [](types::MotionSource source) {
        return source == types::MotionSource::Vision;
    });
}

// The steps within a rest state no error; its last pose has that of the whole rest.
void add_rests(const std::vector<types::Rest>& rests,
               std::int64_t from_ns,
               std::int64_t to_ns,
               optimisation::MotionVariance& variance) {
    for (const types::Rest& rest : rests) {
        if (rest.to_ns <= from_ns || rest.from_ns >= to_ns) continue;
        variance.position_m2 += rest.sigma_m * rest.sigma_m;
        variance.rotation_rad2 += rest.sigma_rad * rest.sigma_rad;
    }
}

}  // namespace

MotionsInSight motions_in_sight(const types::Track& track) {
    MotionsInSight motions(track.keyframes.size());
    for (std::size_t k = 1; k < track.keyframes.size(); ++k) {
        const std::int64_t from_ns = track.keyframes[k - 1].timestamp_ns;
        const std::int64_t to_ns = track.keyframes[k].timestamp_ns;
        const std::size_t from = optimisation::frame_at(track.odometry, from_ns);
        const std::size_t to = optimisation::frame_at(track.odometry, to_ns);
        if (!all_by_vision(track, from, to)) continue;
        optimisation::MotionVariance variance =
            optimisation::summed_variances(track.sigmas, from, to).back();
        add_rests(track.rests, from_ns, to_ns, variance);
        motions[k] = {std::sqrt(variance.position_m2), std::sqrt(variance.rotation_rad2)};
    }
    return motions;
}

}  // namespace divemesh::loops
