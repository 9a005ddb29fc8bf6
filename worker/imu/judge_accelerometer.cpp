#include "worker/imu/judge_accelerometer.hpp"

#include <algorithm>
#include <variant>

#include "worker/base/seconds.hpp"
#include "worker/imu/preintegration.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::imu {
namespace {

constexpr std::int64_t kSpan_ns = 500'000'000;
constexpr std::size_t kSpansOfForce = 2;  // on either side
constexpr std::size_t kMinForces = 10;
constexpr std::size_t kMaxForces = 60;
constexpr std::size_t kLag = 4;  // forces: two seconds
// A bias of a tenth rotates with the rig, and images of little detail are off by as much.
constexpr double kWrongForce_m_s2 = 0.3;
// Over slower frames the bias of the gyroscope, which is not removed, rotates gravity.
constexpr std::int64_t kMaxInterval_ns = 300'000'000;

std::vector<Difference> last_forces(const std::vector<Difference>& forces) {
    const auto num = static_cast<std::ptrdiff_t>(std::min(forces.size(), kMaxForces));
    return {forces.end() - num, forces.end()};
}

}  // namespace

void GravityByVision::start(std::int64_t time_ns) {
    q_first_body_ = Eigen::Quaterniond::Identity();
    velocity_.setZero();
    lead_.setZero();
    runs_.emplace_back();
    marks_ = {Mark{time_ns, lead_}};
}

void GravityByVision::add(const VisionMotion& motion) {
    const auto preintegrated = preintegrate(samples_, motion.from_ns, motion.to_ns, {}, {});
    const auto* by_imu = std::get_if<PreintegratedImu>(&preintegrated);
    if (!by_imu || motion.to_ns - motion.from_ns > kMaxInterval_ns) {
        marks_.clear();
        return;
    }
    if (marks_.empty() || motion.from_ns != last_ns_) start(motion.from_ns);
    lead_ += velocity_ * base::to_s(motion.to_ns - motion.from_ns) +
             q_first_body_ * (by_imu->delta_position - motion.T_from_to.translation());
    velocity_ += q_first_body_ * by_imu->delta_velocity;
    q_first_body_ = (q_first_body_ * Eigen::Quaterniond(motion.T_from_to.linear())).normalized();
    last_ns_ = motion.to_ns;
    if (last_ns_ - marks_.back().time_ns >= kSpan_ns) finish_span();
}

void GravityByVision::finish_span() {
    marks_.push_back({last_ns_, lead_});
    if (marks_.size() <= 2 * kSpansOfForce) return;
    const Mark& a = marks_.front();
    const Mark& b = marks_[kSpansOfForce];
    const Mark& c = marks_.back();
    const Eigen::Vector3d before = (b.lead - a.lead) / base::to_s(b.time_ns - a.time_ns);
    const Eigen::Vector3d after = (c.lead - b.lead) / base::to_s(c.time_ns - b.time_ns);
    // Most of the weight of a second difference is in its middle half.
    const types::TimeInterval middle{(a.time_ns + b.time_ns) / 2, (b.time_ns + c.time_ns) / 2};
    runs_.back().push_back({middle, 2.0 * (after - before) / base::to_s(c.time_ns - a.time_ns)});
    marks_.erase(marks_.begin());
}

std::optional<double> GravityByVision::disagreement_m_s2() const {
    if (runs_.empty()) return std::nullopt;
    const std::vector<Difference> forces = last_forces(runs_.back());
    const auto wrong = imu::wrong_times(forces, kWrongForce_m_s2);
    const auto is_wrong = [&](const Difference& force) {
        return std::any_of(wrong.begin(), wrong.end(), [&](const types::TimeInterval& time) {
            return force.time.to_ns > time.from_ns && force.time.from_ns < time.to_ns;
        });
    };
    std::vector<double> distances;
    for (std::size_t i = kLag; i < forces.size(); ++i)
        if (!is_wrong(forces[i]) && !is_wrong(forces[i - kLag]))
            distances.push_back((forces[i].value - forces[i - kLag].value).norm());
    if (distances.size() + kLag < kMinForces) return std::nullopt;
    return stats::median(std::move(distances));
}

std::vector<types::TimeInterval> GravityByVision::wrong_times() const {
    std::vector<types::TimeInterval> times;
    for (const std::vector<Difference>& forces : runs_) {
        const auto found = imu::wrong_times(forces, kWrongForce_m_s2);
        times.insert(times.end(), found.begin(), found.end());
    }
    return times;
}

}  // namespace divemesh::imu
