#include "worker/evaluation/accelerometer_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "worker/base/rotation_vector.hpp"
#include "worker/base/seconds.hpp"
#include "worker/base/text.hpp"
#include "worker/evaluation/rotation_between_frames.hpp"
#include "worker/imu/preintegration.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::evaluation {
namespace {

constexpr std::int64_t kMinWindow_ns = 2'000'000'000;
// The frames of a window sample w'', whose frequencies end at two per window. With ten frames a
// motion is taken for one of these frequencies only if it swings eight times in the window.
constexpr std::int64_t kFramesOfWindow = 12;
constexpr std::int64_t kMinFramesOfWindow = 10;
// Further apart they miss the swings of a diver's fins.
constexpr std::int64_t kMaxFrameInterval_ns = 600'000'000;
constexpr std::int64_t kMaxSampleGap_ns = 150'000'000;
constexpr std::int64_t kTimeOfOneBias_ns = 60'000'000'000;
constexpr std::ptrdiff_t kMinWindows = 5;
// The IMU is where the calibration says to this; many calibrations state no lever arm at all.
constexpr double kLeverSigma_m = 0.05;
constexpr double kAxesSigma_rad = 0.005;  // of an accelerometer's to its gyroscope's
constexpr int kVarianceRounds = 3;
// Windows that overlap by half share white noise: twice the correlation of sin^4 and cos^4.
constexpr double kOverlap = 1.0 + 2.0 * 3.0 / 70.0;
// Separates gravity and bias if the rig never rotates. The prior on gravity has about its true
// uncertainty, so that its pull is negligible beside the residuals of a short dive.
constexpr double kWeakPrior = 1e-6;

// The scale s, s l, and e.
constexpr int kNumShared = 7;
constexpr int kNumSeen = 4;  // of them with the path
using SharedVector = Eigen::Matrix<double, kNumShared, 1>;
using SharedMatrix = Eigen::Matrix<double, kNumShared, kNumShared>;

// A window's equation: accelerated = shared (s, s l, e) + unknowns, see the header.
struct Equation {
    // Integral w (R a + g) dt, with g as known.
    Eigen::Vector3d accelerated = Eigen::Vector3d::Zero();
    // Integral w'' (p, R) dt and integral w R (a x) dt.
    Eigen::Matrix<double, 3, kNumShared> shared = Eigen::Matrix<double, 3, kNumShared>::Zero();
    Eigen::Matrix<double, 3, 6> unknowns =
        Eigen::Matrix<double, 3, 6>::Zero();  // of the deviation of g, and of b
};

// Returns p and R side by side.
Eigen::Matrix<double, 3, kNumSeen> position_and_axes(const types::StampedPose& pose) {
    return pose.T_world_imu.matrix().topRows<3>()(Eigen::all, {3, 0, 1, 2});
}

struct Window {
    std::int64_t start_ns = 0;
    std::int64_t length_ns = kMinWindow_ns;

    double phase(std::int64_t time_ns) const {
        return std::numbers::pi * static_cast<double>(time_ns - start_ns) /
               static_cast<double>(length_ns);
    }
    double weight(std::int64_t time_ns) const { return std::pow(std::sin(phase(time_ns)), 4); }
    double second_derivative(std::int64_t time_ns) const {  // 1/s^2
        const double rate = std::numbers::pi / base::to_s(length_ns);
        const double s = std::sin(phase(time_ns)), c = std::cos(phase(time_ns));
        return rate * rate * (12.0 * s * s * c * c - 4.0 * s * s * s * s);
    }
    std::int64_t end_ns() const { return start_ns + length_ns; }
};

std::int64_t median_interval_ns(const types::Trajectory& trajectory) {
    std::vector<std::int64_t> intervals_ns;
    for (std::size_t i = 1; i < trajectory.size(); ++i)
        intervals_ns.push_back(trajectory[i].timestamp_ns - trajectory[i - 1].timestamp_ns);
    return intervals_ns.empty() ? 0 : stats::upper_median(std::move(intervals_ns));
}

std::int64_t window_ns(const types::Trajectory& trajectory) {
    return std::max(kMinWindow_ns, kFramesOfWindow * median_interval_ns(trajectory));
}

// Returns the windows of a path, each half a window after the one before.
std::vector<Window> windows_of(const types::Trajectory& trajectory) {
    std::vector<Window> windows;
    if (trajectory.empty()) return windows;
    for (Window window{trajectory.front().timestamp_ns, window_ns(trajectory)};
         window.end_ns() <= trajectory.back().timestamp_ns;
         window.start_ns += window.length_ns / 2)
        windows.push_back(window);
    return windows;
}

// The entries within a window, with their weights in a trapezoidal sum; w is zero at both ends.
// Empty if there is a gap among them.
template <typename Entry>
struct Covered {
    const Entry* first = nullptr;
    std::vector<double> weights_s;
};
template <typename Entry>
Covered<Entry> covered(const std::vector<Entry>& entries,
                       const Window& window,
                       std::int64_t max_gap_ns) {
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
        if (entry->timestamp_ns - last_ns > max_gap_ns ||
            next_ns - entry->timestamp_ns > max_gap_ns)
            return {};
        result.weights_s.push_back(0.5e-9 * static_cast<double>(next_ns - last_ns));
        last_ns = entry->timestamp_ns;
    }
    return result;
}

Covered<types::StampedPose> frames_in(const types::Trajectory& trajectory, const Window& window) {
    return covered(trajectory, window, window.length_ns / kMinFramesOfWindow);
}

std::optional<Equation> equation(const std::vector<types::ImuSample>& imu,
                                 const types::Trajectory& trajectory,
                                 const RotationBetweenFrames& rotation,
                                 const Window& window) {
    const auto frames = frames_in(trajectory, window);
    const auto samples = covered(imu, window, kMaxSampleGap_ns);
    if (frames.weights_s.empty() || samples.weights_s.empty()) return std::nullopt;
    Equation result;
    const types::StampedPose& from = frames.first[0];
    const types::StampedPose& to = frames.first[frames.weights_s.size() - 1];
    const Eigen::Matrix<double, 3, kNumSeen> first = position_and_axes(from);
    const Eigen::Matrix<double, 3, kNumSeen> way = position_and_axes(to) - first;
    for (std::size_t i = 0; i < frames.weights_s.size(); ++i) {
        const types::StampedPose& frame = frames.first[i];
        // A uniform change does not contribute to w''; removing it reduces the numerical error of
        // the sum.
        const double share = static_cast<double>(frame.timestamp_ns - from.timestamp_ns) /
                             static_cast<double>(to.timestamp_ns - from.timestamp_ns);
        result.shared.leftCols<kNumSeen>() += frames.weights_s[i] *
                                              window.second_derivative(frame.timestamp_ns) *
                                              (position_and_axes(frame) - first - share * way);
    }
    for (std::size_t i = 0; i < samples.weights_s.size(); ++i) {
        const types::ImuSample& sample = samples.first[i];
        const double weight_s = samples.weights_s[i] * window.weight(sample.timestamp_ns);
        if (weight_s == 0.0) continue;
        const auto R_world_imu = rotation.at(sample.timestamp_ns);
        if (!R_world_imu) return std::nullopt;
        result.accelerated += weight_s * (*R_world_imu * sample.acceleration_imu -
                                          imu::kGravity_m_s2 * Eigen::Vector3d::UnitZ());
        result.shared.rightCols<3>() +=
            weight_s * *R_world_imu * base::cross_matrix(sample.acceleration_imu);
        result.unknowns.leftCols<3>() -= weight_s * Eigen::Matrix3d::Identity();
        result.unknowns.rightCols<3>() += weight_s * *R_world_imu;
    }
    return result;
}

std::vector<Equation> equations_of(const std::vector<types::ImuSample>& imu,
                                   const types::Trajectory& trajectory) {
    const RotationBetweenFrames rotation(imu, trajectory);
    std::vector<Equation> equations;
    for (const Window& window : windows_of(trajectory))
        if (const auto found = equation(imu, trajectory, rotation, window))
            equations.push_back(*found);
    return equations;
}

// Normal equations of several windows with common gravity and bias for the shared unknowns, without
// the part that gravity and bias explain.
struct NormalEquations {
    SharedMatrix information = SharedMatrix::Zero();
    SharedVector right = SharedVector::Zero();
    double squares = 0.0;  // of the right-hand sides
    std::ptrdiff_t num_equations = 0;

    // Returns the variance of an equation. With it the priors have a weight, and so the number of
    // unknowns that the equations determine.
    double variance() const;
};

// Returns the information that is there before the dive; s is close to 1, and not known.
SharedMatrix prior_information() {
    SharedVector weights;
    weights << 0.0, Eigen::Vector3d::Constant(std::pow(kLeverSigma_m, -2)),
        Eigen::Vector3d::Constant(std::pow(kAxesSigma_rad, -2));
    return weights.asDiagonal();
}

double NormalEquations::variance() const {
    double variance = (squares - right[0] * right[0] / information(0, 0)) /
                      static_cast<double>(num_equations - 1);
    for (int i = 0; i < kVarianceRounds; ++i) {
        const auto solver = SharedMatrix(information + variance * prior_information()).ldlt();
        const SharedVector shared = solver.solve(right);
        const double num_determined = solver.solve(information).trace();
        variance = (squares - 2.0 * shared.dot(right) + shared.dot(information * shared)) /
                   (static_cast<double>(num_equations) - num_determined);
    }
    return variance * kOverlap;
}

NormalEquations without_gravity_and_bias(const Equation* first, std::ptrdiff_t num) {
    constexpr int kNumKnown = kNumShared + 1;
    Eigen::Matrix<double, 6, 6> A = kWeakPrior * Eigen::Matrix<double, 6, 6>::Identity();
    Eigen::Matrix<double, 6, kNumKnown> B = Eigen::Matrix<double, 6, kNumKnown>::Zero();
    Eigen::Matrix<double, kNumKnown, kNumKnown> C =
        Eigen::Matrix<double, kNumKnown, kNumKnown>::Zero();
    for (const Equation* e = first; e != first + num; ++e) {
        Eigen::Matrix<double, 3, kNumKnown> known;
        known << e->shared, e->accelerated;
        A += e->unknowns.transpose() * e->unknowns;
        B += e->unknowns.transpose() * known;
        C += known.transpose() * known;
    }
    const Eigen::Matrix<double, kNumKnown, kNumKnown> left = C - B.transpose() * A.ldlt().solve(B);
    return {left.topLeftCorner<kNumShared, kNumShared>(),
            left.topRightCorner<kNumShared, 1>(),
            left(kNumShared, kNumShared),
            3 * num - 6};
}

}  // namespace

std::optional<AccelerometerFit> fit_accelerometer(const std::vector<types::ImuSample>& imu,
                                                  const types::Trajectory& trajectory) {
    if (imu.empty() || median_interval_ns(trajectory) > kMaxFrameInterval_ns) return std::nullopt;
    const std::vector<Equation> equations = equations_of(imu, trajectory);
    const std::ptrdiff_t windows_of_one_bias = 2 * kTimeOfOneBias_ns / window_ns(trajectory);
    const std::ptrdiff_t num = std::ssize(equations);
    const std::ptrdiff_t num_groups = std::max<std::ptrdiff_t>(1, num / windows_of_one_bias);
    SharedMatrix information = prior_information();
    SharedVector right = SharedVector::Zero();
    for (std::ptrdiff_t group = 0; group < num_groups; ++group) {
        const std::ptrdiff_t begin = num * group / num_groups;
        const std::ptrdiff_t size = num * (group + 1) / num_groups - begin;
        if (size < kMinWindows) return std::nullopt;
        const NormalEquations normal = without_gravity_and_bias(equations.data() + begin, size);
        if (normal.information(0, 0) <= 0.0) continue;
        const double variance = normal.variance();
        if (!(variance > 0.0)) continue;
        information += normal.information / variance;
        right += normal.right / variance;
    }
    if (information(0, 0) <= 0.0) return std::nullopt;
    const SharedMatrix covariance = information.inverse();
    const SharedVector shared = covariance * right;
    return AccelerometerFit{{shared[0], std::sqrt(covariance(0, 0))},
                            shared.segment<3>(1) / shared[0],
                            covariance.block<3, 3>(1, 1)};
}

std::optional<ScaleCheck> scale_by_accelerometer(const std::vector<types::ImuSample>& imu,
                                                 const types::Trajectory& trajectory) {
    const auto fit = fit_accelerometer(imu, trajectory);
    return fit ? std::optional(fit->scale) : std::nullopt;
}

std::string why_no_scale_by_accelerometer(const std::vector<types::ImuSample>& imu,
                                          const types::Trajectory& trajectory) {
    if (imu.empty()) return "the dive has no IMU, or its accelerometer is not used";
    if (median_interval_ns(trajectory) > kMaxFrameInterval_ns)
        return "frames are further apart than " + base::fixed(base::to_s(kMaxFrameInterval_ns), 1) +
               " s, too far to compare them with the accelerometer";
    const std::vector<Window> windows = windows_of(trajectory);
    if (std::ssize(windows) < kMinWindows)
        return "the path is shorter than the " +
               base::fixed(base::to_s((kMinWindows + 1) * window_ns(trajectory) / 2), 1) +
               " s that the accelerometer needs";
    const auto num_with_frames = std::ranges::count_if(windows, [&](const Window& window) {
        return !frames_in(trajectory, window).weights_s.empty();
    });
    if (num_with_frames < kMinWindows)
        return "frames of the path are missing too often to compare them with the accelerometer";
    if (std::ssize(equations_of(imu, trajectory)) < kMinWindows)
        return "the IMU covers too little of the dive without a gap";
    return "there is no motion to compare with the accelerometer";
}

}  // namespace divemesh::evaluation
