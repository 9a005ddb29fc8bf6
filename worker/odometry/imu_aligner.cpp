#include "worker/odometry/imu_aligner.hpp"

#include "worker/imu/usable_samples.hpp"

namespace divemesh::odometry {
namespace {

constexpr std::int64_t kMinInterval_ns = 2'000'000'000;
constexpr std::size_t kMaxRotations = 600;

}  // namespace

ImuAligner::ImuAligner(const types::Recording& recording,
                       const types::SensorsLeftOut& left_out,
                       double time_offset_s)
    : start_s_(time_offset_s),
      samples_(imu::aligned(imu::usable_rates(recording, left_out), {time_offset_s})) {
    alignment_.time_offset_s = time_offset_s;
}

void ImuAligner::watch(const imu::VisionMotion& motion, imu::InertialPrior& inertial) {
    if (!inertial.has_gyroscope() || rotations_.size() >= kMaxRotations) return;
    rotations_.push_back(motion.rotation());
    const std::int64_t now_ns = motion.to_ns;
    if (rotations_.size() < next_size_ || now_ns - rotations_.front().from_ns < kMinInterval_ns)
        return;
    next_size_ = rotations_.size() + rotations_.size() / 2;
    const auto estimate = imu::estimate_alignment(samples_, rotations_);
    if (!estimate) return;
    types::ImuAlignment alignment{start_s_};
    if (estimate->time_offset_is_significant())
        alignment.time_offset_s += estimate->alignment.time_offset_s;
    if (estimate->rotation_is_significant()) alignment.q_body_imu = estimate->alignment.q_body_imu;
    alignment_ = alignment;
    inertial.align(alignment);
}

}  // namespace divemesh::odometry
