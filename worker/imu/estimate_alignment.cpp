#include "worker/imu/estimate_alignment.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "worker/base/rotation_vector.hpp"
#include "worker/base/seconds.hpp"
#include "worker/imu/gyroscope_path.hpp"
#include "worker/stats/median.hpp"
#include "worker/stats/robust.hpp"

namespace divemesh::imu {
namespace {

using Vector7 = Eigen::Matrix<double, 7, 1>;  // time offset, rotation, bias
using Matrix7 = Eigen::Matrix<double, 7, 7>;

constexpr int kNumSteps = 8;
constexpr std::size_t kMinRotations = 20;
constexpr std::int64_t kReach_ns = 70'000'000;  // kNearOffset_s and a margin
constexpr std::int64_t kCoarseStep_ns = 4'000'000;
constexpr double kDerivativeStep_s = 2e-3;
constexpr double kPriorOffset_s = 0.03;
constexpr double kPriorRotation_rad = 0.035;
constexpr double kPriorBias = 0.1;       // rad/s
constexpr double kHuber = 3.0;           // of the norm, in sigmas of an axis
constexpr double kMinSigma_rad = 1e-5;   // of a rotation from vision
constexpr double kSignificant = 4.0;     // sigmas
constexpr double kMinOffset_s = 1.5e-3;  // correcting a smaller one risks more than it gains
constexpr double kMinRotation_rad = 4e-3;
// Noise that both measure as rotation looks like information about clock and axes: the derivatives
// of the least squares contain the gyroscope's. With less motion than this nothing is estimated.
constexpr double kMinSignalToNoise = 4.0;
// Rotations in a row whose errors may be correlated: they share landmarks and what moves in them.
constexpr std::size_t kCorrelated = 12;

struct State {
    double offset_s = 0.0;
    Eigen::Quaterniond q_body_imu = Eigen::Quaterniond::Identity();
    Eigen::Vector3d bias = Eigen::Vector3d::Zero();
};

// Returns the mean squared distance from the mean.
double variance(const std::vector<Eigen::Vector3d>& vectors) {
    const auto num = static_cast<double>(vectors.size());
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& vector : vectors) mean += vector / num;
    double sum = 0.0;
    for (const Eigen::Vector3d& vector : vectors) sum += (vector - mean).squaredNorm();
    return sum / num;
}

class Fit {
public:
    Fit(const GyroscopePath& path, const std::vector<VisionRotation>& rotations) : path_(path) {
        for (const VisionRotation& rotation : rotations)
            if (path_.covers(rotation.from_ns - kReach_ns, rotation.to_ns + kReach_ns))
                rotations_.push_back({rotation,
                                      base::vector_from_rotation(rotation.q_from_to),
                                      base::to_s(rotation.to_ns - rotation.from_ns)});
    }

    std::size_t num_rotations() const { return rotations_.size(); }

    // Returns the sum of the residuals' norms, robust against outliers.
    double cost(const State& state) const {
        double sum = 0.0;
        for (const TimedRotation& rotation : rotations_) sum += residual(state, rotation).norm();
        return sum;
    }

    // Returns the smaller of the gyroscope's and vision's energy about their mean, over that of the
    // residuals: the excess of the other is noise.
    double signal_to_noise(const State& state) const {
        std::vector<Eigen::Vector3d> by_gyroscope;
        std::vector<Eigen::Vector3d> by_vision;
        for (const TimedRotation& rotation : rotations_) {
            by_gyroscope.push_back(gyroscope(rotation, state.offset_s));
            by_vision.push_back(rotation.vector);
        }
        const double sigma = scale(state);
        return std::min(variance(by_gyroscope), variance(by_vision)) / (3.0 * sigma * sigma);
    }

    // Returns how many rotations count as one, 1 or more: the sum of the autocorrelation of the
    // residuals in both directions, with a Bartlett window over kCorrelated rotations (Newey and
    // West 1987). Motion changes more slowly, so that it is the factor of all variances.
    double num_correlated(const State& state) const {
        std::vector<Eigen::Vector3d> residuals;
        const double sigma = scale(state);
        for (const TimedRotation& rotation : rotations_) {
            const Eigen::Vector3d r = residual(state, rotation);
            residuals.push_back(std::min(1.0, kHuber * sigma / std::max(r.norm(), 1e-12)) * r);
        }
        const auto covariance = [&](std::size_t lag) {
            double sum = 0.0;
            for (std::size_t i = lag; i < residuals.size(); ++i)
                sum += residuals[i].dot(residuals[i - lag]);
            return sum;
        };
        const double variance = std::max(covariance(0), 1e-20);
        double num = 1.0;
        for (std::size_t lag = 1; lag < std::min(kCorrelated, residuals.size()); ++lag)
            num += 2.0 * (1.0 - static_cast<double>(lag) / static_cast<double>(kCorrelated)) *
                   covariance(lag) / variance;
        return std::max(1.0, num);
    }

    // Does one Gauss-Newton step and returns the covariance. The time offset changes only if
    // `free_offset`.
    Matrix7 step(State& state, bool free_offset) const {
        const double sigma = scale(state);
        Matrix7 H = Matrix7::Zero();
        Vector7 g = Vector7::Zero();
        for (const TimedRotation& rotation : rotations_) add(state, rotation, sigma, H, g);
        Vector7 weight;
        weight << std::pow(kPriorOffset_s, -2),
            Eigen::Vector3d::Constant(std::pow(kPriorRotation_rad, -2)),
            Eigen::Vector3d::Constant(std::pow(kPriorBias, -2));
        Vector7 prior_error;
        prior_error << state.offset_s, base::vector_from_rotation(state.q_body_imu), state.bias;
        H.diagonal() += weight;
        g += weight.cwiseProduct(prior_error);
        if (!free_offset) {
            H.row(0).setZero();
            H.col(0).setZero();
            H(0, 0) = 1.0;
            g(0) = 0.0;
        }
        Matrix7 covariance = H.ldlt().solve(Matrix7::Identity());
        const Vector7 change = -covariance * g;
        const double reach_s = base::to_s(kReach_ns);
        state.offset_s = std::clamp(state.offset_s + change(0), -reach_s, reach_s);
        state.q_body_imu =
            (base::rotation_from_vector(change.segment<3>(1)) * state.q_body_imu).normalized();
        state.bias += change.tail<3>();
        return covariance;
    }

private:
    struct TimedRotation {
        VisionRotation seen;
        Eigen::Vector3d vector;
        double duration_s;
    };

    Eigen::Vector3d gyroscope(const TimedRotation& rotation, double offset_s) const {
        const std::int64_t shift_ns = base::to_ns(offset_s);
        return path_.rotation(rotation.seen.from_ns + shift_ns, rotation.seen.to_ns + shift_ns);
    }
    Eigen::Vector3d residual(const State& state, const TimedRotation& rotation) const {
        return rotation.vector - (state.q_body_imu * gyroscope(rotation, state.offset_s) -
                                  rotation.duration_s * state.bias);
    }
    // Returns the standard deviation per axis, from the median of the norms.
    double scale(const State& state) const {
        std::vector<double> norms;
        for (const TimedRotation& rotation : rotations_)
            norms.push_back(residual(state, rotation).norm());
        return std::max(stats::upper_median(std::move(norms)) / stats::kMedianNormOfThree,
                        kMinSigma_rad);
    }
    void add(const State& state,
             const TimedRotation& rotation,
             double sigma,
             Matrix7& H,
             Vector7& g) const {
        const Eigen::Vector3d r = residual(state, rotation);
        Eigen::Matrix<double, 3, 7> J;
        J.col(0) = -(state.q_body_imu * (gyroscope(rotation, state.offset_s + kDerivativeStep_s) -
                                         gyroscope(rotation, state.offset_s - kDerivativeStep_s))) /
                   (2.0 * kDerivativeStep_s);
        J.middleCols<3>(1) =
            base::cross_matrix(state.q_body_imu * gyroscope(rotation, state.offset_s));
        J.rightCols<3>() = rotation.duration_s * Eigen::Matrix3d::Identity();
        const double weight =
            std::min(1.0, kHuber * sigma / std::max(r.norm(), 1e-12)) / (sigma * sigma);
        H += weight * J.transpose() * J;
        g += weight * J.transpose() * r;
    }

    const GyroscopePath& path_;
    std::vector<TimedRotation> rotations_;
};

// Returns whether the last step moved offset and rotation by less than their uncertainty.
bool has_converged(const State& before, const State& after, const Matrix7& covariance) {
    const Eigen::Vector3d turned =
        base::vector_from_rotation(after.q_body_imu * before.q_body_imu.conjugate());
    const Eigen::Matrix3d rotation = covariance.block<3, 3>(1, 1);
    return std::abs(after.offset_s - before.offset_s) < std::sqrt(covariance(0, 0)) &&
           turned.dot(rotation.ldlt().solve(turned)) < 3.0;
}

// Returns whether the offset lies where it was held back: its minimum may lie beyond.
bool is_at_end(const State& state) { return std::abs(state.offset_s) >= base::to_s(kReach_ns); }

// Returns the best of a series of time offsets, each with its best rotation and bias.
State coarse(const Fit& fit) {
    State best;
    double min_cost = -1.0;
    for (std::int64_t lag_ns = -kReach_ns; lag_ns <= kReach_ns; lag_ns += kCoarseStep_ns) {
        State state;
        state.offset_s = base::to_s(lag_ns);
        for (int i = 0; i < 2; ++i) fit.step(state, false);
        const double cost = fit.cost(state);
        if (min_cost >= 0.0 && cost >= min_cost) continue;
        min_cost = cost;
        best = state;
    }
    return best;
}

}  // namespace

std::vector<types::ImuSample> aligned(const std::vector<types::ImuSample>& samples,
                                      const types::ImuAlignment& alignment) {
    std::vector<types::ImuSample> result = samples;
    for (types::ImuSample& sample : result) {
        sample.timestamp_ns -= base::to_ns(alignment.time_offset_s);
        sample.angular_velocity_imu =
            alignment.q_body_imu * (sample.angular_velocity_imu -
                                    alignment.rate_error.cwiseProduct(sample.angular_velocity_imu));
        sample.acceleration_imu = alignment.q_body_imu * sample.acceleration_imu;
    }
    return result;
}

std::vector<types::OrientationSample> aligned(const std::vector<types::OrientationSample>& samples,
                                              const types::ImuAlignment& alignment) {
    std::vector<types::OrientationSample> result = samples;
    for (types::OrientationSample& sample : result) {
        sample.timestamp_ns -= base::to_ns(alignment.time_offset_s);
        sample.q_world_imu = sample.q_world_imu * alignment.q_body_imu.conjugate();
    }
    return result;
}

bool AlignmentEstimate::time_offset_is_significant() const {
    return std::abs(alignment.time_offset_s) >
           std::max(kMinOffset_s, kSignificant * time_offset_sigma_s);
}

bool AlignmentEstimate::rotation_is_significant() const {
    const Eigen::Vector3d w = base::vector_from_rotation(alignment.q_body_imu);
    return w.norm() > kMinRotation_rad &&
           w.dot(rotation_covariance.ldlt().solve(w)) > kSignificant * kSignificant;
}

std::optional<AlignmentEstimate> estimate_alignment(const std::vector<types::ImuSample>& samples,
                                                    const std::vector<VisionRotation>& rotations) {
    if (rotations.size() < kMinRotations) return std::nullopt;
    const GyroscopePath path(
        samples, rotations.front().from_ns - 2 * kReach_ns, rotations.back().to_ns + 2 * kReach_ns);
    const Fit fit(path, rotations);
    if (fit.num_rotations() < kMinRotations) return std::nullopt;
    State state = coarse(fit);
    State before;
    Matrix7 covariance;
    for (int i = 0; i < kNumSteps; ++i) {
        before = state;
        covariance = fit.step(state, true);
    }
    if (!has_converged(before, state, covariance) || is_at_end(state)) return std::nullopt;
    if (fit.signal_to_noise(state) < kMinSignalToNoise) return std::nullopt;
    AlignmentEstimate estimate;
    estimate.alignment = {state.offset_s, state.q_body_imu};
    covariance *= fit.num_correlated(state);
    estimate.time_offset_sigma_s = std::sqrt(covariance(0, 0));
    estimate.rotation_covariance = covariance.block<3, 3>(1, 1);
    estimate.gyroscope_bias_body = state.bias;
    return estimate;
}

}  // namespace divemesh::imu
