#include "worker/evaluation/rotation_between_frames.hpp"

#include <algorithm>
#include <iterator>
#include <limits>

#include "worker/base/rotation_vector.hpp"

namespace divemesh::evaluation {

RotationBetweenFrames::RotationBetweenFrames(const std::vector<types::ImuSample>& imu,
                                             const types::Trajectory& trajectory)
    : gyroscope_(
          imu, std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::max()) {
    for (std::size_t i = 1; i < trajectory.size(); ++i) {
        const types::StampedPose& from = trajectory[i - 1];
        const types::StampedPose& to = trajectory[i];
        if (to.timestamp_ns <= from.timestamp_ns) continue;
        Interval interval{from.timestamp_ns,
                          to.timestamp_ns,
                          Eigen::Quaterniond(from.T_world_imu.linear()),
                          gyroscope_.covers(from.timestamp_ns, to.timestamp_ns)};
        const Eigen::Quaterniond q_world_to(to.T_world_imu.linear());
        interval.missed_rad = base::vector_from_rotation(
            (interval.q_world_from * by_gyroscope(interval, interval.to_ns)).conjugate() *
            q_world_to);
        intervals_.push_back(interval);
    }
}

std::optional<Eigen::Matrix3d> RotationBetweenFrames::at(std::int64_t time_ns) const {
    const auto next = std::upper_bound(
        intervals_.begin(),
        intervals_.end(),
        time_ns,
        [](std::int64_t time, const Interval& interval) { return time < interval.from_ns; });
    if (next == intervals_.begin() || std::prev(next)->to_ns < time_ns) return std::nullopt;
    const Interval& interval = *std::prev(next);
    const double share = static_cast<double>(time_ns - interval.from_ns) /
                         static_cast<double>(interval.to_ns - interval.from_ns);
    return (interval.q_world_from * by_gyroscope(interval, time_ns) *
            base::rotation_from_vector(share * interval.missed_rad))
        .toRotationMatrix();
}

// Returns the rotation since the start of an interval; none without a gyroscope.
Eigen::Quaterniond RotationBetweenFrames::by_gyroscope(const Interval& interval,
                                                       std::int64_t time_ns) const {
    if (!interval.has_gyroscope) return Eigen::Quaterniond::Identity();
    return base::rotation_from_vector(gyroscope_.rotation(interval.from_ns, time_ns));
}

}  // namespace divemesh::evaluation
