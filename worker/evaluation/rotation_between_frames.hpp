#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "worker/imu/gyroscope_path.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::evaluation {

// The rotation of the body to the world at any time of a path. Between two frames it follows the
// gyroscope; what the gyroscope misses of the second frame, most of it by its bias, is spread
// evenly over the time between them. Where its samples leave a gap, the rotation is uniform.
class RotationBetweenFrames {
public:
    // `imu` are on the cameras' clock.
    RotationBetweenFrames(const std::vector<types::ImuSample>& imu,
                          const types::Trajectory& trajectory);

    // Returns nullopt before the first frame and after the last.
    std::optional<Eigen::Matrix3d> at(std::int64_t time_ns) const;

private:
    struct Interval {
        std::int64_t from_ns = 0;
        std::int64_t to_ns = 0;
        Eigen::Quaterniond q_world_from = Eigen::Quaterniond::Identity();
        bool has_gyroscope = false;
        Eigen::Vector3d missed_rad = Eigen::Vector3d::Zero();  // by the gyroscope, at the end
    };
    Eigen::Quaterniond by_gyroscope(const Interval& interval, std::int64_t time_ns) const;

    imu::GyroscopePath gyroscope_;
    std::vector<Interval> intervals_;  // in the order of time
};

}  // namespace divemesh::evaluation
