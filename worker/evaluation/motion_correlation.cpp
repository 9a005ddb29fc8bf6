#include "worker/evaluation/motion_correlation.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "worker/base/rotation_vector.hpp"
#include "worker/base/seconds.hpp"
#include "worker/evaluation/trajectory_pairs.hpp"

namespace divemesh::evaluation {
namespace {

constexpr double kMinCorrelation = 0.3;
constexpr std::size_t kMaxCandidates = 5;

double duration_s(const types::Trajectory& trajectory) {
    return base::to_s(trajectory.back().timestamp_ns - trajectory.front().timestamp_ns);
}

// Returns rates at equal time steps from the first pose; NaN where unknown.
std::vector<double> rates(const types::Trajectory& trajectory, double step_s, bool of_rotation) {
    const double reach_s =
        std::max(0.05, duration_s(trajectory) / static_cast<double>(trajectory.size() - 1));
    const auto count = static_cast<std::size_t>(duration_s(trajectory) / step_s) + 1;
    std::vector<double> result(count, std::nan(""));
    for (std::size_t i = 0; i < count; ++i) {
        const auto time_ns =
            trajectory.front().timestamp_ns + base::to_ns(static_cast<double>(i) * step_s);
        const auto before = pose_at(trajectory, time_ns - base::to_ns(reach_s));
        const auto after = pose_at(trajectory, time_ns + base::to_ns(reach_s));
        if (!before || !after) continue;
        const Eigen::Isometry3d change = before->inverse() * *after;
        result[i] = (of_rotation ? base::angle_rad(change.linear()) : change.translation().norm()) /
                    (2.0 * reach_s);
    }
    return result;
}

// Returns Pearson's correlation over the samples that both have; nullopt for fewer than
// `min_num_samples`.
std::optional<double> correlation(const std::vector<double>& a,
                                  const std::vector<double>& b,
                                  std::ptrdiff_t lag,
                                  std::size_t min_num_samples) {
    double n = 0.0, sa = 0.0, sb = 0.0, saa = 0.0, sbb = 0.0, sab = 0.0;
    const auto first = static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, -lag));
    for (std::size_t i = first; i < a.size(); ++i) {
        const auto j = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(i) + lag);
        if (j >= b.size()) break;
        if (std::isnan(a[i]) || std::isnan(b[j])) continue;
        n += 1.0;
        sa += a[i];
        sb += b[j];
        saa += a[i] * a[i];
        sbb += b[j] * b[j];
        sab += a[i] * b[j];
    }
    if (n < static_cast<double>(min_num_samples)) return std::nullopt;
    const double variance = (saa - sa * sa / n) * (sbb - sb * sb / n);
    return variance > 0.0 ? (sab - sa * sb / n) / std::sqrt(variance) : 0.0;
}

struct Candidate {
    double correlation = 0.0;
    std::ptrdiff_t lag = 0;
};

std::vector<Candidate> peaks(const std::vector<double>& estimate,
                             const std::vector<double>& truth) {
    const std::size_t min_num_samples = std::max<std::size_t>(20, estimate.size() / 2);
    std::vector<Candidate> all;
    for (auto lag = -std::ssize(estimate); lag < std::ssize(truth); ++lag)
        if (const auto value = correlation(estimate, truth, lag, min_num_samples))
            all.push_back({*value, lag});
    std::vector<Candidate> found;
    for (std::size_t i = 0; i < all.size(); ++i)
        if (all[i].correlation >= kMinCorrelation &&
            (i == 0 || all[i].correlation >= all[i - 1].correlation) &&
            (i + 1 == all.size() || all[i].correlation > all[i + 1].correlation))
            found.push_back(all[i]);
    std::stable_sort(found.begin(), found.end(), [](const Candidate& a, const Candidate& b) {
        return a.correlation > b.correlation;
    });
    found.resize(std::min(found.size(), kMaxCandidates));
    return found;
}

}  // namespace

bool has_rotation(const types::Trajectory& trajectory) {
    constexpr double kMinOrientationChange_rad = 0.035;
    return std::any_of(trajectory.begin(), trajectory.end(), [&](const types::StampedPose& pose) {
        const Eigen::Matrix3d R =
            trajectory.front().T_world_imu.linear().transpose() * pose.T_world_imu.linear();
        return base::angle_rad(R) > kMinOrientationChange_rad;
    });
}

std::vector<double> likely_time_offsets_s(const types::Trajectory& estimate,
                                          const types::Trajectory& truth) {
    constexpr double kMinStep_s = 0.05;
    constexpr double kMaxProducts = 1.5e9;
    if (estimate.size() < 3 || truth.size() < 3) return {};
    const double step_s =
        std::max(kMinStep_s, std::sqrt(duration_s(estimate) * duration_s(truth) / kMaxProducts));
    const bool of_rotation = has_rotation(estimate) && has_rotation(truth);
    const double starts_apart_s =
        base::to_s(truth.front().timestamp_ns - estimate.front().timestamp_ns);
    std::vector<double> offsets_s;
    for (const Candidate& peak :
         peaks(rates(estimate, step_s, of_rotation), rates(truth, step_s, of_rotation)))
        offsets_s.push_back(starts_apart_s + static_cast<double>(peak.lag) * step_s);
    return offsets_s;
}

}  // namespace divemesh::evaluation
