#include "worker/odometry/imu_aligner.hpp"

#include "worker/imu/usable_samples.hpp"

namespace divemesh::odometry {
namespace {

constexpr std::int64_t kMinInterval_ns = 2'000'000'000;
constexpr std::size_t kMaxRotations = 600;

}  // namespace

ImuAligner::ImuAligner(const types::Recording& recording,
                       const types::SensorsLeftOut& left_out,
                       const types::ImuAlignment& start,
                       std::size_t num_known)
    : start_s_(start.time_offset_s),
      num_known_(num_known),
      samples_(imu::aligned(imu::usable_rates(recording, left_out), {start.time_offset_s})),
      alignment_(start) {}

void ImuAligner::watch(const imu::VisionMotion& motion, imu::InertialPrior& inertial) {
    if (!inertial.has_gyroscope() || rotations_.size() >= kMaxRotations) return;
    rotations_.push_back(motion.rotation());
    const std::int64_t now_ns = motion.to_ns;
    if (rotations_.size() < next_size_ || now_ns - rotations_.front().from_ns < kMinInterval_ns)
        return;
    next_size_ = rotations_.size() + rotations_.size() / 2;
    if (rotations_.size() <= num_known_) return;
    const auto estimate = imu::estimate_alignment(samples_, rotations_);
    if (!estimate) return;
    types::ImuAlignment alignment{start_s_};
    if (estimate->time_offset_is_significant())
        alignment.time_offset_s += estimate->alignment.time_offset_s;
    if (estimate->rotation_is_significant()) alignment.q_body_imu = estimate->alignment.q_body_imu;
    alignment_ = alignment;
    num_known_ = rotations_.size();
    inertial.align(alignment);
}

}  // namespace divemesh::odometry
