#include "worker/imu/gyroscope_path.hpp"

#include <algorithm>

#include "worker/base/rotation_vector.hpp"
#include "worker/base/seconds.hpp"
#include "worker/imu/imu_steps.hpp"

namespace divemesh::imu {

GyroscopePath::GyroscopePath(const std::vector<types::ImuSample>& samples,
                             std::int64_t from_ns,
                             std::int64_t to_ns) {
    auto sample = std::lower_bound(
        samples.begin(), samples.end(), from_ns, [](const types::ImuSample& s, std::int64_t time) {
            return s.timestamp_ns < time;
        });
    for (; sample != samples.end() && sample->timestamp_ns <= to_ns; ++sample) {
        const bool first = samples_.empty();
        q_.push_back(first ? Eigen::Quaterniond::Identity() : rotated(samples_.back(), *sample));
        const bool gap =
            !first && sample->timestamp_ns - samples_.back().timestamp_ns > kMaxImuGap_ns;
        num_gaps_.push_back(first ? 0 : num_gaps_.back() + (gap ? 1 : 0));
        samples_.push_back(*sample);
    }
}

bool GyroscopePath::covers(std::int64_t from_ns, std::int64_t to_ns) const {
    return samples_.size() > 1 && from_ns >= samples_.front().timestamp_ns &&
           to_ns <= samples_.back().timestamp_ns &&
           num_gaps_[first_after(from_ns) - 1] == num_gaps_[first_after(to_ns)];
}

Eigen::Vector3d GyroscopePath::rotation(std::int64_t from_ns, std::int64_t to_ns) const {
    return base::vector_from_rotation(at(from_ns).conjugate() * at(to_ns));
}

// Returns the sample after a time; at the end, the last.
std::size_t GyroscopePath::first_after(std::int64_t time_ns) const {
    const auto after = std::upper_bound(samples_.begin() + 1,
                                        samples_.end() - 1,
                                        time_ns,
                                        [](std::int64_t time, const types::ImuSample& sample) {
                                            return time < sample.timestamp_ns;
                                        });
    return static_cast<std::size_t>(after - samples_.begin());
}

Eigen::Quaterniond GyroscopePath::rotated(const types::ImuSample& before,
                                          const types::ImuSample& after) const {
    const double dt_s = base::to_s(after.timestamp_ns - before.timestamp_ns);
    return (q_.back() *
            base::rotation_from_vector(0.5 * dt_s *
                                       (before.angular_velocity_imu + after.angular_velocity_imu)))
        .normalized();
}

Eigen::Quaterniond GyroscopePath::at(std::int64_t time_ns) const {
    const std::size_t i = first_after(time_ns);
    const types::ImuSample& before = samples_[i - 1];
    const types::ImuSample& after = samples_[i];
    const double since_s = base::to_s(time_ns - before.timestamp_ns);
    const double whole_s = base::to_s(after.timestamp_ns - before.timestamp_ns);
    const Eigen::Vector3d rate =
        before.angular_velocity_imu +
        0.5 * since_s / whole_s * (after.angular_velocity_imu - before.angular_velocity_imu);
    return q_[i - 1] * base::rotation_from_vector(rate * since_s);
}

}  // namespace divemesh::imu
