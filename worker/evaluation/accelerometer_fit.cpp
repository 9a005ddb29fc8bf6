#include "worker/evaluation/accelerometer_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "worker/base/rotation_vector.hpp"
#include "worker/base/seconds.hpp"
#include "worker/base/text.hpp"
#include "worker/evaluation/rotation_between_frames.hpp"
#include "worker/imu/preintegration.hpp"
#include "worker/stats/distributions.hpp"
#include "worker/stats/median.hpp"
#include "worker/stats/robust.hpp"

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
constexpr double kMaxNoise = 0.5;         // share of the accelerations
constexpr int kVarianceRounds = 4;
constexpr double kEqualVariances = 0.95;  // confidence up to which windows have equal errors
constexpr double kFirstVariance = 1e-6;   // m^2/s^4; of a good path
// Windows that overlap by half share white noise: twice the correlation of sin^4 and cos^4.
constexpr double kOverlap = 1.0 + 2.0 * 3.0 / 70.0;
// A tilt of the path by three degrees, and the bias of a cheap accelerometer.
constexpr double kGravityAndBiasSigma_m_s2 = 0.5;

// 1 / s, l and e / s: see the header.
constexpr int kNumShared = 7;
using SharedVector = Eigen::Matrix<double, kNumShared, 1>;
using SharedMatrix = Eigen::Matrix<double, kNumShared, kNumShared>;

// A window's equation: seen = shared (1 / s, l, e / s) + unknowns, see the header.
struct Equation {
    Eigen::Vector3d seen = Eigen::Vector3d::Zero();  // integral w'' p dt
    // Integral w (R a + g) dt with g as known, -integral w'' R dt and -integral w R (a x) dt.
    Eigen::Matrix<double, 3, kNumShared> shared = Eigen::Matrix<double, 3, kNumShared>::Zero();
    Eigen::Matrix<double, 3, 6> unknowns =
        Eigen::Matrix<double, 3, 6>::Zero();  // of the deviation of g, and of b, over s
    double squared_weights_s2 = 0.0;          // of the samples
};

using Matrix34 = Eigen::Matrix<double, 3, 4>;

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

// Returns p and R side by side.
Matrix34 position_and_axes(const Eigen::Vector3d& position, const Eigen::Matrix3d& axes) {
    Matrix34 both;
    both << position, axes;
    return both;
}

// Returns integral w'' (p, R) dt over the frames of a window. R follows the gyroscope from the
// first frame to the last: vision takes a part of a rotation for a motion of the scene's distance
// times as far, which would look like an arm of that length.
std::optional<Matrix34> seen_by(const Covered<types::StampedPose>& frames,
                                const std::vector<types::ImuSample>& imu,
                                const Window& window) {
    const types::StampedPose& from = frames.first[0];
    const types::StampedPose& to = frames.first[frames.weights_s.size() - 1];
    const auto begin = std::ranges::lower_bound(
        imu, from.timestamp_ns - kMaxSampleGap_ns, {}, &types::ImuSample::timestamp_ns);
    const auto end = std::ranges::upper_bound(
        imu, to.timestamp_ns + kMaxSampleGap_ns, {}, &types::ImuSample::timestamp_ns);
    const RotationBetweenFrames rotation({begin, end}, {from, to});
    const auto first = position_and_axes(from.T_world_imu.translation(), from.T_world_imu.linear());
    const Matrix34 way =
        position_and_axes(to.T_world_imu.translation(), to.T_world_imu.linear()) - first;
    Matrix34 sum = Matrix34::Zero();
    for (std::size_t i = 0; i < frames.weights_s.size(); ++i) {
        const types::StampedPose& frame = frames.first[i];
        const auto R_world_imu = rotation.at(frame.timestamp_ns);
        if (!R_world_imu) return std::nullopt;
        // A uniform change does not contribute to w''; removing it reduces the numerical error of
        // the sum.
        const double share = static_cast<double>(frame.timestamp_ns - from.timestamp_ns) /
                             static_cast<double>(to.timestamp_ns - from.timestamp_ns);
        sum += frames.weights_s[i] * window.second_derivative(frame.timestamp_ns) *
               (position_and_axes(frame.T_world_imu.translation(), *R_world_imu) - first -
                share * way);
    }
    return sum;
}

std::optional<Equation> equation(const std::vector<types::ImuSample>& imu,
                                 const types::Trajectory& trajectory,
                                 const RotationBetweenFrames& rotation,
                                 const Window& window) {
    const auto frames = frames_in(trajectory, window);
    const auto samples = covered(imu, window, kMaxSampleGap_ns);
    if (frames.weights_s.empty() || samples.weights_s.empty()) return std::nullopt;
    const auto seen = seen_by(frames, imu, window);
    if (!seen) return std::nullopt;
    Equation result;
    result.seen = seen->col(0);
    result.shared.middleCols<3>(1) = -seen->rightCols<3>();
    for (std::size_t i = 0; i < samples.weights_s.size(); ++i) {
        const types::ImuSample& sample = samples.first[i];
        const double weight_s = samples.weights_s[i] * window.weight(sample.timestamp_ns);
        if (weight_s == 0.0) continue;
        const auto R_world_imu = rotation.at(sample.timestamp_ns);
        if (!R_world_imu) return std::nullopt;
        result.shared.col(0) += weight_s * (*R_world_imu * sample.acceleration_imu -
                                            imu::kGravity_m_s2 * Eigen::Vector3d::UnitZ());
        result.shared.rightCols<3>() -=
            weight_s * *R_world_imu * base::cross_matrix(sample.acceleration_imu);
        result.unknowns.leftCols<3>() += weight_s * Eigen::Matrix3d::Identity();
        result.unknowns.rightCols<3>() -= weight_s * *R_world_imu;
        result.squared_weights_s2 += weight_s * weight_s;
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
    double squares = 0.0;  // of the left-hand sides
    double noise = 0.0;    // expected part of information(0, 0)
    std::ptrdiff_t num_equations = 0;

    // Returns the information without the noise of the accelerations: with it they would look
    // larger than they are (errors in variables, Fuller 1987).
    SharedMatrix corrected() const;
    // Finds the variance of an equation. With it the priors have a weight, and so the number of
    // unknowns that the equations determine.
    void find_variance();

    double variance = kFirstVariance;
    double degrees_of_freedom = 0.0;  // of the variance
};

// Returns the information that is there before the dive. s is close to 1, and not known.
SharedMatrix prior_information() {
    SharedVector weights;
    weights << 0.0, Eigen::Vector3d::Constant(std::pow(kLeverSigma_m, -2)),
        Eigen::Vector3d::Constant(std::pow(kAxesSigma_rad, -2));
    return weights.asDiagonal();
}

SharedMatrix NormalEquations::corrected() const {
    SharedMatrix result = information;
    result(0, 0) -= std::min(noise, kMaxNoise * information(0, 0));
    return result;
}

void NormalEquations::find_variance() {
    const SharedMatrix without_noise = corrected();
    double rest = squares;
    for (int i = 0; i < kVarianceRounds; ++i) {
        const auto solver = SharedMatrix(without_noise + variance * prior_information()).ldlt();
        const SharedVector shared = solver.solve(right);
        degrees_of_freedom =
            static_cast<double>(num_equations) - solver.solve(without_noise).trace();
        rest = squares - 2.0 * shared.dot(right) + shared.dot(information * shared);
        variance = kOverlap * rest / degrees_of_freedom;
    }
    degrees_of_freedom /= kOverlap;
}

// Returns the standard deviation of the white noise of a sample along an axis, from the differences
// of neighbours.
double noise_m_s2(const std::vector<types::ImuSample>& imu) {
    std::vector<double> steps;
    for (std::size_t i = 1; i < imu.size(); ++i)
        for (int axis = 0; axis < 3; ++axis)
            steps.push_back(
                std::abs(imu[i].acceleration_imu[axis] - imu[i - 1].acceleration_imu[axis]));
    if (steps.empty()) return 0.0;
    return stats::kSigmasPerMad * stats::upper_median(std::move(steps)) / std::numbers::sqrt2;
}

// `noise_m_s2` is that of a sample, `variance` that of an equation, which gives priors their
// weight.
NormalEquations without_gravity_and_bias(const Equation* first,
                                         std::ptrdiff_t num,
                                         double noise_m_s2,
                                         double variance) {
    constexpr int kNumKnown = kNumShared + 1;
    Eigen::Matrix<double, 6, 6> A = variance * std::pow(kGravityAndBiasSigma_m_s2, -2) *
                                    Eigen::Matrix<double, 6, 6>::Identity();
    Eigen::Matrix<double, 6, kNumKnown> B = Eigen::Matrix<double, 6, kNumKnown>::Zero();
    Eigen::Matrix<double, kNumKnown, kNumKnown> C =
        Eigen::Matrix<double, kNumKnown, kNumKnown>::Zero();
    double noise = 0.0;
    for (const Equation* e = first; e != first + num; ++e) {
        Eigen::Matrix<double, 3, kNumKnown> known;
        known << e->shared, e->seen;
        A += e->unknowns.transpose() * e->unknowns;
        B += e->unknowns.transpose() * known;
        C += known.transpose() * known;
        noise += 3.0 * noise_m_s2 * noise_m_s2 * e->squared_weights_s2;
    }
    const Eigen::Matrix<double, kNumKnown, kNumKnown> left = C - B.transpose() * A.ldlt().solve(B);
    const double share = static_cast<double>(num - 2) / static_cast<double>(num);
    return {left.topLeftCorner<kNumShared, kNumShared>(),
            left.topRightCorner<kNumShared, 1>(),
            left(kNumShared, kNumShared),
            share * noise,
            3 * num - 6};
}

// Returns by how much a sigma of so many degrees of freedom is wider than a known one, at three
// sigmas.
double widening_of(double degrees_of_freedom) {
    constexpr double kShare = 0.99865;
    return stats::student_t_quantile(kShare, std::max(1.0, degrees_of_freedom)) /
           stats::normal_quantile(kShare);
}

// What a window tells about 1 / s, by the row of the covariance that belongs to it.
struct ScaleEvidence {
    double squared_lever = 0.0;  // of the window's errors, in sigmas, on 1 / s
    double squared_error = 0.0;  // of 1 / s, by the window's residual
};

// Adds the evidence of the windows of one bias, given the shared unknowns and the first row of
// their covariance.
void add_scale_evidence(const Equation* first,
                        std::ptrdiff_t num,
                        double variance,
                        const SharedVector& shared,
                        const SharedVector& row,
                        std::vector<ScaleEvidence>& evidence) {
    Eigen::Matrix<double, 6, 6> A = variance * std::pow(kGravityAndBiasSigma_m_s2, -2) *
                                    Eigen::Matrix<double, 6, 6>::Identity();
    Eigen::Matrix<double, 6, 2> B = Eigen::Matrix<double, 6, 2>::Zero();
    const auto known = [&](const Equation& e) {
        Eigen::Matrix<double, 3, 2> both;
        both << e.shared * row, e.seen - e.shared * shared;
        return both;
    };
    for (const Equation* e = first; e != first + num; ++e) {
        A += e->unknowns.transpose() * e->unknowns;
        B += e->unknowns.transpose() * known(*e);
    }
    const Eigen::Matrix<double, 6, 2> explained = A.ldlt().solve(B);
    for (const Equation* e = first; e != first + num; ++e) {
        const Eigen::Matrix<double, 3, 2> left = known(*e) - e->unknowns * explained;
        const double error = left.col(0).dot(left.col(1)) / variance;
        evidence.push_back({left.col(0).squaredNorm() / variance, error * error});
    }
}

// Returns the variance of 1 / s. It is `equal`, that of equal errors in all windows and `widening`
// times as wide in its sigma, unless the windows that tell the scale have larger ones (White 1980):
// a path is exact while the rig rests.
double variance_of_scale(const std::vector<ScaleEvidence>& evidence,
                         double equal,
                         double widening) {
    double levers = 0.0;
    double squared_levers = 0.0;
    double errors = 0.0;
    for (const ScaleEvidence& window : evidence) {
        levers += window.squared_lever;
        squared_levers += window.squared_lever * window.squared_lever;
        errors += window.squared_error;
    }
    const double assumed = widening * widening * equal;
    if (!(squared_levers > 0.0)) return assumed;
    const double num = levers * levers / squared_levers;  // of the windows that tell it
    const double unequal = kOverlap * errors;
    if (unequal / equal * num < stats::chi_square_quantile(kEqualVariances, num)) return assumed;
    const double by_few = widening_of(num - 1.0);
    return std::max(assumed, by_few * by_few * unequal * num / std::max(1.0, num - 1.0));
}

}  // namespace

std::optional<AccelerometerFit> fit_accelerometer(const std::vector<types::ImuSample>& imu,
                                                  const types::Trajectory& trajectory) {
    if (imu.empty() || median_interval_ns(trajectory) > kMaxFrameInterval_ns) return std::nullopt;
    const std::vector<Equation> equations = equations_of(imu, trajectory);
    const std::ptrdiff_t windows_of_one_bias = 2 * kTimeOfOneBias_ns / window_ns(trajectory);
    const std::ptrdiff_t num = std::ssize(equations);
    const std::ptrdiff_t num_groups = std::max<std::ptrdiff_t>(1, num / windows_of_one_bias);
    const auto range_of = [&](std::ptrdiff_t group) {
        const std::ptrdiff_t begin = num * group / num_groups;
        return std::pair(begin, num * (group + 1) / num_groups - begin);
    };
    const double noise = noise_m_s2(imu);
    SharedMatrix information = prior_information();
    SharedVector right = SharedVector::Zero();
    double degrees_of_freedom = 0.0;
    std::vector<double> variances;  // of the groups; 0: it tells nothing
    for (std::ptrdiff_t group = 0; group < num_groups; ++group) {
        const auto [begin, size] = range_of(group);
        if (size < kMinWindows) return std::nullopt;
        NormalEquations normal;
        for (int i = 0; i < kVarianceRounds; ++i) {
            const double variance = normal.variance;
            normal = without_gravity_and_bias(equations.data() + begin, size, noise, variance);
            normal.variance = variance;
            if (normal.information(0, 0) > 0.0) normal.find_variance();
        }
        const bool tells = normal.information(0, 0) > 0.0 && normal.variance > 0.0;
        variances.push_back(tells ? normal.variance : 0.0);
        if (!tells) continue;
        information += normal.corrected() / normal.variance;
        right += normal.right / normal.variance;
        degrees_of_freedom += normal.degrees_of_freedom;
    }
    if (information(0, 0) <= 0.0) return std::nullopt;
    const SharedVector shared = information.ldlt().solve(right);
    // The variances are those of the residuals, few of a short dive.
    const double widening = widening_of(degrees_of_freedom);
    const SharedMatrix covariance = information.inverse();
    if (!(shared[0] > 0.0)) return std::nullopt;
    std::vector<ScaleEvidence> evidence;
    for (std::ptrdiff_t group = 0; group < num_groups; ++group) {
        const auto [begin, size] = range_of(group);
        const double variance = variances[static_cast<std::size_t>(group)];
        if (variance > 0.0)
            add_scale_evidence(
                equations.data() + begin, size, variance, shared, covariance.col(0), evidence);
    }
    const double sigma = std::sqrt(variance_of_scale(evidence, covariance(0, 0), widening));
    return AccelerometerFit{{1.0 / shared[0], sigma / (shared[0] * shared[0])},
                            shared.segment<3>(1),
                            widening * widening * covariance.block<3, 3>(1, 1),
                            num};
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
