#include "worker/evaluation/imu_check.hpp"

#include <cmath>

#include "worker/base/angle.hpp"
#include "worker/evaluation/trajectory_pairs.hpp"

namespace divemesh::evaluation {
namespace {}  // namespace

std::optional<GravityCheck> check_gravity(const std::vector<types::ImuSample>& imu,
                                          const types::Trajectory& trajectory) {
    Eigen::Vector3d sum_world = Eigen::Vector3d::Zero();
    double count = 0.0;
    for (const types::ImuSample& sample : imu) {
        const auto T_world_imu = pose_at(trajectory, sample.timestamp_ns);
        if (!T_world_imu) continue;
        sum_world += T_world_imu->linear() * sample.acceleration_imu;
        count += 1.0;
    }
    if (count == 0.0) return std::nullopt;
    const Eigen::Vector3d mean_world = sum_world / count;
    const double across = mean_world.head<2>().norm();
    return GravityCheck{mean_world.norm(), std::atan2(across, mean_world.z()) * base::kDegPerRad};
}

}  // namespace divemesh::evaluation
