#include "worker/imu/judge_accelerometer.hpp"

#include <variant>

#include "worker/imu/preintegration.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::imu {
namespace {

constexpr std::int64_t kSpan_ns = 500'000'000;
constexpr std::size_t kMinForces = 10;
constexpr std::size_t kMaxForces = 60;
// Slower frames do not tell the velocity at their times.
constexpr std::int64_t kMaxInterval_ns = 300'000'000;

Eigen::Vector3d median_of(const std::vector<Eigen::Vector3d>& vectors) {
    Eigen::Vector3d result;
    for (int axis = 0; axis < 3; ++axis) {
        std::vector<double> values;
        for (const Eigen::Vector3d& v : vectors) values.push_back(v[axis]);
        result[axis] = stats::median(std::move(values));
    }
    return result;
}

}  // namespace

void GravityByVision::start(const VisionMotion& motion) {
    started_ = true;
    q_first_body_ = Eigen::Quaterniond::Identity();
    forces_.clear();
    span_began_ns_ = motion.from_ns;
    integral_.setZero();
    velocity_at_begin_ = motion.T_from_to.translation() /
                         (1e-9 * static_cast<double>(motion.to_ns - motion.from_ns));
}

void GravityByVision::add(const VisionMotion& motion) {
    const auto preintegrated = preintegrate(samples_, motion.from_ns, motion.to_ns, {}, {});
    const auto* by_imu = std::get_if<PreintegratedImu>(&preintegrated);
    if (!by_imu || motion.to_ns - motion.from_ns > kMaxInterval_ns) {
        started_ = false;
        return;
    }
    const bool follows = started_ && motion.from_ns == last_ns_;
    if (!follows) start(motion);
    const double dt_s = 1e-9 * static_cast<double>(motion.to_ns - motion.from_ns);
    const Eigen::Vector3d velocity = q_first_body_ * motion.T_from_to.translation() / dt_s;
    // The velocity at a frame is the mean of those before and after.
    if (follows && motion.from_ns - span_began_ns_ >= kSpan_ns)
        finish_span(0.5 * (last_velocity_ + velocity), motion.from_ns);
    integral_ += q_first_body_ * by_imu->delta_velocity;
    q_first_body_ = (q_first_body_ * Eigen::Quaterniond(motion.T_from_to.linear())).normalized();
    last_velocity_ = velocity;
    last_ns_ = motion.to_ns;
}

void GravityByVision::finish_span(const Eigen::Vector3d& velocity, std::int64_t now_ns) {
    const double dt_s = 1e-9 * static_cast<double>(now_ns - span_began_ns_);
    forces_.emplace_back((integral_ - (velocity - velocity_at_begin_)) / dt_s);
    if (forces_.size() > kMaxForces) forces_.erase(forces_.begin());
    span_began_ns_ = now_ns;
    velocity_at_begin_ = velocity;
    integral_.setZero();
}

std::optional<double> GravityByVision::disagreement_m_s2() const {
    if (forces_.size() < kMinForces) return std::nullopt;
    const Eigen::Vector3d usual = median_of(forces_);
    std::vector<double> distances;
    for (const Eigen::Vector3d& force : forces_) distances.push_back((force - usual).norm());
    return stats::median(std::move(distances));
}

}  // namespace divemesh::imu
