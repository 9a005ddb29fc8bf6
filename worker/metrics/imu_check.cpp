#include "worker/metrics/imu_check.hpp"

#include <algorithm>
#include <cmath>

#include "worker/metrics/trajectory_pairs.hpp"

namespace divemesh::worker {
namespace {

constexpr double kDegPerRad = 57.29577951308232;
constexpr std::int64_t kLagStep_ns = 1'000'000;
constexpr std::int64_t kNumLags = 50;  // to either side

// The gyro's sum of turns, so that a mean rate over any interval is one difference. Turns within
// a frame are small enough to be added.
class TurnIntegral {
public:
    explicit TurnIntegral(const std::vector<ImuSample>& imu)
        : imu_(imu), sums_(imu.size(), Eigen::Vector3d::Zero()) {
        for (std::size_t i = 1; i < imu.size(); ++i) {
            const double dt_s =
                static_cast<double>(imu[i].timestamp_ns - imu[i - 1].timestamp_ns) * 1e-9;
            sums_[i] = sums_[i - 1] +
                       0.5 * dt_s * (imu[i].angular_velocity_imu + imu[i - 1].angular_velocity_imu);
        }
    }

    bool covers(std::int64_t from_ns, std::int64_t to_ns) const {
        return !imu_.empty() && from_ns >= imu_.front().timestamp_ns &&
               to_ns <= imu_.back().timestamp_ns;
    }
    Eigen::Vector3d until(std::int64_t time_ns) const {
        const auto after = std::upper_bound(
            imu_.begin(), imu_.end(), time_ns, [](std::int64_t time, const ImuSample& sample) {
                return time < sample.timestamp_ns;
            });
        if (after == imu_.end()) return sums_.back();
        const auto i = static_cast<std::size_t>(after - imu_.begin());
        const double share = static_cast<double>(time_ns - imu_[i - 1].timestamp_ns) /
                             static_cast<double>(imu_[i].timestamp_ns - imu_[i - 1].timestamp_ns);
        return (1.0 - share) * sums_[i - 1] + share * sums_[i];
    }

private:
    const std::vector<ImuSample>& imu_;
    std::vector<Eigen::Vector3d> sums_;
};

// One step of the trajectory: its mean turn rate in the body.
struct Turn {
    std::int64_t from_ns = 0;
    std::int64_t to_ns = 0;
    Eigen::Vector3d rate = Eigen::Vector3d::Zero();  // rad/s
};

double seconds(const Turn& turn) { return static_cast<double>(turn.to_ns - turn.from_ns) * 1e-9; }

std::vector<Turn> turns_of(const Trajectory& trajectory, const TurnIntegral& gyro) {
    constexpr std::int64_t kReach_ns = kNumLags * kLagStep_ns;
    std::vector<Turn> turns;
    for (std::size_t i = 1; i < trajectory.size(); ++i) {
        const StampedPose& from = trajectory[i - 1];
        const StampedPose& to = trajectory[i];
        Turn turn{from.timestamp_ns, to.timestamp_ns};
        if (!gyro.covers(turn.from_ns - kReach_ns, turn.to_ns + kReach_ns) || seconds(turn) > 0.5)
            continue;
        const Eigen::AngleAxisd angle(from.T_world_imu.linear().transpose() *
                                      to.T_world_imu.linear());
        turn.rate = angle.angle() / seconds(turn) * angle.axis();
        turns.push_back(turn);
    }
    return turns;
}

// Variance of gyro minus trajectory with the gyro shifted; the mean is its bias and plays no part.
double variance_at(const std::vector<Turn>& turns, const TurnIntegral& gyro, std::int64_t lag_ns) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double squares = 0.0;
    for (const Turn& turn : turns) {
        const Eigen::Vector3d difference =
            (gyro.until(turn.to_ns + lag_ns) - gyro.until(turn.from_ns + lag_ns)) / seconds(turn) -
            turn.rate;
        sum += difference;
        squares += difference.squaredNorm();
    }
    const auto count = static_cast<double>(turns.size());
    return squares / count - (sum / count).squaredNorm();
}

}  // namespace

std::optional<GravityCheck> check_gravity(const std::vector<ImuSample>& imu,
                                          const Trajectory& trajectory) {
    Eigen::Vector3d sum_world = Eigen::Vector3d::Zero();
    double count = 0.0;
    for (const ImuSample& sample : imu) {
        const auto T_world_imu = pose_at(trajectory, sample.timestamp_ns);
        if (!T_world_imu) continue;
        sum_world += T_world_imu->linear() * sample.acceleration_imu;
        count += 1.0;
    }
    if (count == 0.0) return std::nullopt;
    const Eigen::Vector3d mean_world = sum_world / count;
    const double across = mean_world.head<2>().norm();
    return GravityCheck{mean_world.norm(), std::atan2(across, mean_world.z()) * kDegPerRad};
}

std::optional<double> estimate_time_offset_s(const std::vector<ImuSample>& imu,
                                             const Trajectory& trajectory) {
    constexpr std::size_t kLeastTurns = 20;
    constexpr double kLeastGain = 0.02;  // how much worse a shift by the whole reach must be
    const TurnIntegral gyro(imu);
    const std::vector<Turn> turns = turns_of(trajectory, gyro);
    if (turns.size() < kLeastTurns) return std::nullopt;
    std::vector<double> variances;
    for (std::int64_t lag = -kNumLags; lag <= kNumLags; ++lag)
        variances.push_back(variance_at(turns, gyro, lag * kLagStep_ns));
    const auto best = static_cast<std::size_t>(
        std::min_element(variances.begin(), variances.end()) - variances.begin());
    const double worst = std::min(variances.front(), variances.back());
    if (best == 0 || best + 1 == variances.size() || variances[best] > (1.0 - kLeastGain) * worst)
        return std::nullopt;
    const double before = variances[best - 1] - variances[best];
    const double after = variances[best + 1] - variances[best];
    const double top = before + after > 0.0 ? 0.5 * (before - after) / (before + after) : 0.0;
    return (static_cast<double>(best) - static_cast<double>(kNumLags) + top) *
           static_cast<double>(kLagStep_ns) * 1e-9;
}

}  // namespace divemesh::worker
