#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "worker/types/recording.hpp"

namespace divemesh::imu {

// The gyroscope's orientation since its first sample, so that the rotation between any two times is
// one quotient.
class GyroscopePath {
public:
    // Uses the samples between the two times.
    GyroscopePath(const std::vector<types::ImuSample>& samples,
                  std::int64_t from_ns,
                  std::int64_t to_ns);

    // Returns true if samples cover the interval without a gap longer than kMaxImuGap_ns.
    bool covers(std::int64_t from_ns, std::int64_t to_ns) const;
    // Returns the rotation vector from one time to another, rad, in the frame at `from`. Samples
    // must cover the interval.
    Eigen::Vector3d rotation(std::int64_t from_ns, std::int64_t to_ns) const;

private:
    std::size_t first_after(std::int64_t time_ns) const;
    Eigen::Quaterniond rotated(const types::ImuSample& before, const types::ImuSample& after) const;
    Eigen::Quaterniond at(std::int64_t time_ns) const;

    std::vector<types::ImuSample> samples_;
    std::vector<Eigen::Quaterniond> q_;
    std::vector<int> num_gaps_;  // up to each sample
};

}  // namespace divemesh::imu
