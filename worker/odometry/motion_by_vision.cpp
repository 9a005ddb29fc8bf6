#include "worker/odometry/motion_by_vision.hpp"

#include <algorithm>
#include <iterator>

#include "worker/odometry/refine_pose.hpp"

namespace divemesh::odometry {
namespace {

constexpr std::size_t kMinNumPairs = 30;

// Returns the inliers of `vision` as measured. Ids ascend in both.
PointPairs inliers_of(const PointPairs& measured, const Registration& vision) {
    PointPairs inliers;
    std::set_intersection(measured.begin(),
                          measured.end(),
                          vision.inliers.begin(),
                          vision.inliers.end(),
                          std::back_inserter(inliers),
                          [](const PointPair& a, const PointPair& b) { return a.id < b.id; });
    return inliers;
}

}  // namespace

std::optional<imu::VisionMotion> motion_by_vision(const types::RectifiedRig& rig,
                                                  const PointPairs& measured,
                                                  const Registration& vision,
                                                  std::int64_t before_ns,
                                                  std::int64_t now_ns) {
    if (!vision.found || vision.inliers.size() < kMinNumPairs) return std::nullopt;
    const RefinedPose refined = refine_pose(
        rig, inliers_of(measured, vision), {vision.T_current_previous, std::nullopt, 0.0});
    if (refined.outcome.failed()) return std::nullopt;
    return imu::VisionMotion{
        before_ns,
        now_ns,
        rig.T_imu_cam * refined.T_current_previous.inverse() * rig.T_imu_cam.inverse()};
}

}  // namespace divemesh::odometry
