#include "worker/odometry/imu_aligner.hpp"

#include <algorithm>
#include <iterator>

#include "worker/odometry/refine_pose.hpp"

namespace divemesh::odometry {
namespace {

constexpr std::int64_t kMinInterval_ns = 2'000'000'000;
constexpr std::size_t kMaxRotations = 600;
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

void ImuAligner::watch(const types::RectifiedRig& rig,
                       const PointPairs& measured,
                       const Registration& vision,
                       std::int64_t before_ns,
                       std::int64_t now_ns,
                       imu::InertialPrior& inertial) {
    if (!inertial.has_gyroscope() || rotations_.size() >= kMaxRotations) return;
    if (!vision.found || vision.inliers.size() < kMinNumPairs) return;
    const Eigen::Isometry3d T_current_previous =
        refine_pose(
            rig, inliers_of(measured, vision), {vision.T_current_previous, std::nullopt, 0.0})
            .T_current_previous;
    const Eigen::Quaterniond q_body_cam(rig.T_imu_cam.linear());
    const Eigen::Quaterniond q_previous_current(T_current_previous.linear().transpose());
    rotations_.push_back(
        {before_ns, now_ns, q_body_cam * q_previous_current * q_body_cam.conjugate()});
    if (rotations_.size() < next_size_ || now_ns - rotations_.front().from_ns < kMinInterval_ns)
        return;
    next_size_ = rotations_.size() + rotations_.size() / 2;
    const auto estimate = imu::estimate_alignment(samples_, rotations_);
    if (!estimate) return;
    types::ImuAlignment alignment;
    if (estimate->time_offset_is_significant())
        alignment.time_offset_s = estimate->alignment.time_offset_s;
    if (estimate->rotation_is_significant()) alignment.q_body_imu = estimate->alignment.q_body_imu;
    alignment_ = alignment;
    inertial.align(alignment);
}

}  // namespace divemesh::odometry
