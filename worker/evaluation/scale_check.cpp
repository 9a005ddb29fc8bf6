#include "worker/evaluation/scale_check.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "worker/evaluation/trajectory_pairs.hpp"
#include "worker/imu/preintegration.hpp"
#include "worker/stats/distributions.hpp"

namespace divemesh::evaluation {
namespace {

constexpr std::int64_t kWindow_ns = 2'000'000'000;
constexpr std::int64_t kMaxGap_ns = 150'000'000;  // of samples or frames in a window
constexpr std::ptrdiff_t kWindowsOfOneBias = 60;
// Windows that overlap by half share white noise: twice the correlation of sin^4 and cos^4.
constexpr double kOverlap = 1.0 + 2.0 * 3.0 / 70.0;
// Separates gravity and bias if the rig never rotates. The prior on gravity has about its true
// uncertainty, so that its pull is negligible beside the residuals of a short dive.
constexpr double kWeakPrior = 1e-6;
constexpr std::int64_t kPressureBin_ns = 500'000'000;
constexpr std::size_t kMinBins = 20;
constexpr double kMaxCorrelation = 0.95;
constexpr double kContradicts_sigmas = 3.0;
constexpr double kTapeSigma_m = 0.002;

// A window's equation: accelerated = s seen + unknowns, see the header.
struct Equation {
    // Integral w (R a + g) dt, with g as known.
    Eigen::Vector3d accelerated = Eigen::Vector3d::Zero();
    Eigen::Vector3d seen = Eigen::Vector3d::Zero();  // integral w'' p dt
    Eigen::Matrix<double, 3, 6> unknowns =
        Eigen::Matrix<double, 3, 6>::Zero();  // of the deviation of g, and of b
};

struct Window {
    std::int64_t start_ns = 0;

    double phase(std::int64_t time_ns) const {
        return std::numbers::pi * static_cast<double>(time_ns - start_ns) / kWindow_ns;
    }
    double weight(std::int64_t time_ns) const { return std::pow(std::sin(phase(time_ns)), 4); }
    double second_derivative(std::int64_t time_ns) const {  // 1/s^2
        const double rate = std::numbers::pi / (1e-9 * kWindow_ns);
        const double s = std::sin(phase(time_ns)), c = std::cos(phase(time_ns));
        return rate * rate * (12.0 * s * s * c * c - 4.0 * s * s * s * s);
    }
    std::int64_t end_ns() const { return start_ns + kWindow_ns; }
};

// The entries within a window, with their weights in a trapezoidal sum; w is zero at both ends.
// Empty if there is a gap among them.
template <typename Entry>
struct Covered {
    const Entry* first = nullptr;
    std::vector<double> weights_s;
};
template <typename Entry>
Covered<Entry> covered(const std::vector<Entry>& entries, const Window& window) {
    const auto before = [](const Entry& entry, std::int64_t time) {
        return entry.timestamp_ns < time;
    };
    const auto begin = std::lower_bound(entries.begin(), entries.end(), window.start_ns, before);
    const auto end = std::lower_bound(begin, entries.end(), window.end_ns() + 1, before);
    if (begin == end) return {};
    Covered<Entry> result{&*begin, {}};
    std::int64_t last_ns = window.start_ns;
    for (auto entry = begin; entry != end; ++entry) {
        const std::int64_t next_ns =
            std::next(entry) == end ? window.end_ns() : std::next(entry)->timestamp_ns;
        if (entry->timestamp_ns - last_ns > kMaxGap_ns ||
            next_ns - entry->timestamp_ns > kMaxGap_ns)
            return {};
        result.weights_s.push_back(0.5e-9 * static_cast<double>(next_ns - last_ns));
        last_ns = entry->timestamp_ns;
    }
    return result;
}

std::optional<Equation> equation(const std::vector<types::ImuSample>& imu,
                                 const types::Trajectory& trajectory,
                                 const Window& window) {
    const auto frames = covered(trajectory, window);
    const auto samples = covered(imu, window);
    if (frames.weights_s.empty() || samples.weights_s.empty()) return std::nullopt;
    Equation result;
    const types::StampedPose& from = frames.first[0];
    const types::StampedPose& to = frames.first[frames.weights_s.size() - 1];
    const Eigen::Vector3d way = to.T_world_imu.translation() - from.T_world_imu.translation();
    for (std::size_t i = 0; i < frames.weights_s.size(); ++i) {
        const types::StampedPose& frame = frames.first[i];
        // A uniform motion does not contribute to w''; removing it reduces the numerical error of
        // the sum.
        const double share = static_cast<double>(frame.timestamp_ns - from.timestamp_ns) /
                             static_cast<double>(to.timestamp_ns - from.timestamp_ns);
        result.seen +=
            frames.weights_s[i] * window.second_derivative(frame.timestamp_ns) *
            (frame.T_world_imu.translation() - from.T_world_imu.translation() - share * way);
    }
    for (std::size_t i = 0; i < samples.weights_s.size(); ++i) {
        const types::ImuSample& sample = samples.first[i];
        const double weight_s = samples.weights_s[i] * window.weight(sample.timestamp_ns);
        if (weight_s == 0.0) continue;
        const auto T_world_imu = pose_at(trajectory, sample.timestamp_ns);
        if (!T_world_imu) return std::nullopt;
        result.accelerated += weight_s * (T_world_imu->linear() * sample.acceleration_imu -
                                          imu::kGravity_m_s2 * Eigen::Vector3d::UnitZ());
        result.unknowns.leftCols<3>() -= weight_s * Eigen::Matrix3d::Identity();
        result.unknowns.rightCols<3>() += weight_s * T_world_imu->linear();
    }
    return result;
}

// Information of several equations with common gravity and bias about the scale: sums of squares
// and products of the part that gravity and bias do not explain.
struct Information {
    double seen_seen = 0.0;
    double seen_own = 0.0;
    double own_own = 0.0;
    double degrees_of_freedom = 0.0;

    double variance() const {
        return (own_own - seen_own * seen_own / seen_seen) / degrees_of_freedom * kOverlap;
    }
};

Information without_gravity_and_bias(const Equation* first, std::ptrdiff_t num) {
    Eigen::Matrix<double, 6, 6> A = kWeakPrior * Eigen::Matrix<double, 6, 6>::Identity();
    Eigen::Matrix<double, 6, 2> B = Eigen::Matrix<double, 6, 2>::Zero();
    Eigen::Matrix2d C = Eigen::Matrix2d::Zero();
    for (const Equation* e = first; e != first + num; ++e) {
        Eigen::Matrix<double, 3, 2> known;
        known << e->seen, e->accelerated;
        A += e->unknowns.transpose() * e->unknowns;
        B += e->unknowns.transpose() * known;
        C += known.transpose() * known;
    }
    const Eigen::Matrix2d left = C - B.transpose() * A.ldlt().solve(B);
    return {left(0, 0), left(0, 1), left(1, 1), static_cast<double>(3 * num - 7)};
}

// Means of a bin: depth, and the path's -z, x and y.
struct DepthBin {
    double depth_m = 0.0;
    Eigen::Vector4d path = Eigen::Vector4d::Zero();  // -z, x, y, 1
    double num = 0.0;
};

std::vector<DepthBin> depth_bins(const std::vector<types::PressureSample>& pressure,
                                 const types::Trajectory& trajectory) {
    std::vector<DepthBin> bins;
    std::int64_t bin_ends_ns = 0;
    for (const types::PressureSample& sample : pressure) {
        const auto pose = pose_at(trajectory, sample.timestamp_ns);
        if (!pose) continue;
        if (bins.empty() || sample.timestamp_ns >= bin_ends_ns) {
            bins.emplace_back();
            bin_ends_ns = sample.timestamp_ns + kPressureBin_ns;
        }
        const Eigen::Vector3d p = pose->translation();
        bins.back().depth_m += sample.depth_m;
        bins.back().path += Eigen::Vector4d(-p.z(), p.x(), p.y(), 1.0);
        bins.back().num += 1.0;
    }
    for (DepthBin& bin : bins) {
        bin.depth_m /= bin.num;
        bin.path /= bin.num;
    }
    return bins;
}

// Returns the number of correlated residuals that count as one independent residual (Bartlett
// 1946).
double repetition(const Eigen::VectorXd& residuals) {
    const Eigen::Index num = residuals.size();
    const double products = residuals.head(num - 1).dot(residuals.tail(num - 1));
    const double correlation = std::clamp(
        products / residuals.squaredNorm() + 1.0 / static_cast<double>(num), 0.0, kMaxCorrelation);
    return (1.0 + correlation) / (1.0 - correlation);
}

// Returns a standard deviation that was estimated from few independent residuals, widened so that
// three of it hold as much as three of a known one (Student's t).
double wide_sigma(double sigma, double degrees_of_freedom) {
    constexpr double kShare = 0.99865;  // of a normal variable below three sigmas
    return sigma * stats::student_t_quantile(kShare, std::max(1.0, degrees_of_freedom)) /
           kContradicts_sigmas;
}

double sigma_between_m(double length_m, const PathError& path) {
    if (path.extent_m <= 0.0) return 0.0;
    return path.far_sigma_m * std::sqrt(std::min(1.0, length_m / path.extent_m));
}

}  // namespace

std::optional<ScaleCheck> scale_by_accelerometer(const std::vector<types::ImuSample>& imu,
                                                 const types::Trajectory& trajectory) {
    if (imu.empty() || trajectory.empty()) return std::nullopt;
    std::vector<Equation> equations;
    for (Window window{trajectory.front().timestamp_ns};
         window.end_ns() <= trajectory.back().timestamp_ns;
         window.start_ns += kWindow_ns / 2)
        if (const auto found = equation(imu, trajectory, window)) equations.push_back(*found);
    const auto num = static_cast<std::ptrdiff_t>(equations.size());
    const std::ptrdiff_t num_groups = std::max<std::ptrdiff_t>(1, num / kWindowsOfOneBias);
    double information = 0.0;
    double weighted = 0.0;
    for (std::ptrdiff_t group = 0; group < num_groups; ++group) {
        const std::ptrdiff_t begin = num * group / num_groups;
        const std::ptrdiff_t size = num * (group + 1) / num_groups - begin;
        if (3 * size < 14) return std::nullopt;
        const Information left = without_gravity_and_bias(equations.data() + begin, size);
        if (left.seen_seen <= 0.0 || left.variance() <= 0.0) continue;
        information += left.seen_seen / left.variance();
        weighted += left.seen_own / left.variance();
    }
    if (information <= 0.0) return std::nullopt;
    return ScaleCheck{weighted / information, 1.0 / std::sqrt(information)};
}

std::optional<ScaleCheck> scale_by_pressure(const std::vector<types::PressureSample>& pressure,
                                            const types::Trajectory& trajectory,
                                            double sigma_by_poses) {
    const std::vector<DepthBin> bins = depth_bins(pressure, trajectory);
    if (bins.size() < kMinBins) return std::nullopt;
    Eigen::MatrixXd path(std::ssize(bins), 4);
    Eigen::VectorXd depth_m(std::ssize(bins));
    for (Eigen::Index i = 0; i < path.rows(); ++i) {
        path.row(i) = bins[static_cast<std::size_t>(i)].path.transpose();
        depth_m[i] = bins[static_cast<std::size_t>(i)].depth_m;
    }
    const Eigen::Matrix4d information =
        path.transpose() * path + 1e-9 * Eigen::Matrix4d::Identity();
    const Eigen::LDLT<Eigen::Matrix4d> factor(information);
    const Eigen::Vector4d solution = factor.solve(path.transpose() * depth_m);
    const Eigen::VectorXd residuals = depth_m - path * solution;
    const double times = repetition(residuals);
    // A smooth column takes as many degrees of freedom from correlated residuals as `times` columns
    // from white ones.
    const double degrees_of_freedom = std::max(1.0, static_cast<double>(path.rows()) - 4.0 * times);
    const double inverse = factor.solve(Eigen::Vector4d::Unit(0)).x();  // 1 / squares of -z only
    const double variance = residuals.squaredNorm() / degrees_of_freedom * times * inverse;
    const double sigma =
        std::hypot(wide_sigma(std::sqrt(variance), degrees_of_freedom / times), sigma_by_poses);
    if (sigma <= 0.0) return std::nullopt;
    return ScaleCheck{solution[0], sigma};
}

std::optional<ScaleCheck> scale_by_distances(const KnownDistanceErrors& distances,
                                             const PathError& path) {
    if (distances.num_measured < 3) return std::nullopt;
    const double measured_over_known = 1.0 + distances.scale_error;
    double squares = 0.0;
    double known_squares = 0.0;
    double by_poses_m2 = 0.0;
    for (const MeasuredDistance& distance : distances.distances) {
        if (!distance.measured_m) continue;
        const double rest = *distance.measured_m - measured_over_known * distance.known_m;
        squares += rest * rest;
        known_squares += distance.known_m * distance.known_m;
        by_poses_m2 += distance.known_m * sigma_between_m(distance.known_m, path);
    }
    const double sigma = std::hypot(
        std::sqrt(squares / static_cast<double>(distances.num_measured - 1) / known_squares),
        by_poses_m2 / known_squares);
    if (sigma <= 0.0) return std::nullopt;
    return ScaleCheck{1.0 / measured_over_known, sigma};
}

ScaleCheck weighted_mean(const std::vector<ScaleCheck>& checks) {
    const auto information = [](const ScaleCheck& check) {
        return 1.0 / (check.sigma * check.sigma);
    };
    double weight = 0.0;
    double weighted = 0.0;
    for (const ScaleCheck& check : checks) {
        weight += information(check);
        weighted += information(check) * check.scale;
    }
    const double mean = weighted / weight;
    double chi2 = 0.0;
    for (const ScaleCheck& check : checks)
        chi2 += information(check) * std::pow(check.scale - mean, 2);
    const double ratio =
        checks.size() > 1 ? std::sqrt(chi2 / static_cast<double>(checks.size() - 1)) : 1.0;
    return {mean, std::max(1.0, ratio) / std::sqrt(weight)};
}

std::optional<ScaleCheck> scale_by_marked_distances(const KnownDistanceErrors& distances) {
    std::vector<ScaleCheck> checks;
    for (const MeasuredDistance& distance : distances.distances) {
        if (!distance.measured_m || !distance.sigma_m || *distance.measured_m <= 0.0) continue;
        const double sigma_m = std::hypot(*distance.sigma_m, kTapeSigma_m);
        checks.push_back({distance.known_m / *distance.measured_m, sigma_m / *distance.measured_m});
    }
    if (checks.empty()) return std::nullopt;
    return weighted_mean(checks);
}

bool is_contradicted(const ScaleCheck& check) {
    return std::abs(check.scale - 1.0) > kContradicts_sigmas * check.sigma;
}

nlohmann::json to_metrics(const ScaleCheck& check) {
    return {{"scale", check.scale}, {"sigma", check.sigma}};
}

}  // namespace divemesh::evaluation
