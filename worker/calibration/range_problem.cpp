#include "worker/calibration/range_problem.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "worker/base/rotation_vector.hpp"
#include "worker/optimisation/irls_outcome.hpp"
#include "worker/stats/median.hpp"
#include "worker/stats/robust.hpp"

namespace divemesh::calibration {
namespace {

constexpr int kNumSteps = 15;
constexpr int kNumPose = 6;
constexpr int kNumAll = kNumPose + kNumRangeUnknowns;
constexpr std::size_t kMinMatches = 15;  // of a window
constexpr double kMinError_px = 0.03;
constexpr double kMinDisparity = 1e-3;  // of the focal length
// The features of a window err alike, and the scatter of fewer windows does not show by how much:
// these count as if their variances were larger in that proportion.
constexpr double kWindowsThatTell = 4.0;

using AllUnknowns = Eigen::Matrix<double, kNumAll, 1>;  // pose (rotation, translation), shared

// Lengths are in baselines and pixels in focal lengths from the principal point.
struct Sample {
    Eigen::Vector3d before;  // left x, left y, right x
    Eigen::Vector3d after;
};

struct Window {
    Eigen::Isometry3d T_after_before;
    std::vector<Sample> samples;
    std::vector<double> weights;
};

class RangeProblem {
public:
    RangeProblem(const types::RectifiedRig& rig,
                 const std::vector<RangeWindow>& windows,
                 const RangeUnknowns& prior,
                 const RangeUnknowns& prior_sigmas)
        : rig_(rig), prior_(prior), prior_sigmas_(prior_sigmas), values_(prior) {
        for (const RangeWindow& window : windows)
            if (window.matches.size() >= kMinMatches) add(window);
    }

    RangeSolution solve() {
        const std::vector<double> initial_norms = norms();
        double last_step_sigmas = 0.0;
        for (int step = 0; step < kNumSteps; ++step) {
            reweight();
            last_step_sigmas = this->step();
        }
        RangeSolution result = solution();
        if (windows_.empty()) return result;
        result.outcome = optimisation::outcome_of(
            optimisation::IrlsSteps{.num_steps = kNumSteps,
                                    .initial_cost = cost(initial_norms, prior_),
                                    .final_cost = cost(norms(), values_),
                                    .last_step_sigmas = last_step_sigmas});
        return result;
    }

private:
    using Residual = Eigen::Vector3d;
    struct Linearised {
        Residual residual;
        Eigen::Matrix<double, 3, kNumAll> jacobian;
    };
    struct Moved {
        Eigen::Isometry3d T_after_before;
        RangeUnknowns values;
    };
    struct MovedByEach {
        Moved here;
        std::array<Moved, kNumAll> there;
    };
    struct Reduced {
        RangeCovariance information = RangeCovariance::Zero();
        RangeUnknowns gradient = RangeUnknowns::Zero();
        RangeCovariance between_windows = RangeCovariance::Zero();
    };
    struct WindowEquations {
        Eigen::Matrix<double, kNumAll, kNumAll> information =
            Eigen::Matrix<double, kNumAll, kNumAll>::Zero();
        AllUnknowns gradient = AllUnknowns::Zero();
    };

    void add(const RangeWindow& window) {
        Window added{window.T_after_before, {}, {}};
        added.T_after_before.translation() /= rig_.baseline_m;
        for (const RangeMatch& match : window.matches)
            added.samples.push_back({rays(match.before_px), rays(match.after_px)});
        added.weights.assign(added.samples.size(), 1.0);
        windows_.push_back(std::move(added));
    }

    Eigen::Vector3d rays(const Eigen::Vector3d& measured_px) const {
        return {(measured_px.x() - rig_.cx_px) / rig_.focal_px,
                (measured_px.y() - rig_.cy_px) / rig_.focal_px,
                (measured_px.x() - measured_px.z() - rig_.cx_px) / rig_.focal_px};
    }

    // Returns (x, y, disparity) of the left camera for what was measured.
    Eigen::Vector3d corrected(const Eigen::Vector3d& measured, const RangeUnknowns& values) const {
        const double y = measured.y();
        const double left = measured.x();
        const double right = measured.z();
        const double left_radial = values[2] * (left * left + y * y);
        const double right_radial = values[3] * (right * right + y * y);
        const double turned = right + values[0] * (1.0 + right * right);
        const double x = left * (1.0 - left_radial);
        return {x,
                y * (1.0 - left_radial),
                x - (turned - values[1] / rig_.focal_px - right * right_radial)};
    }

    Eigen::Vector3d seen_after(const Eigen::Vector3d& before,
                               const Eigen::Isometry3d& T_after_before) const {
        const double depth = 1.0 / std::max(kMinDisparity, before.z());
        const Eigen::Vector3d p =
            T_after_before * (depth * Eigen::Vector3d(before.x(), before.y(), 1.0));
        const double z = std::max(1e-3, p.z());
        return {p.x() / z, p.y() / z, 1.0 / z};
    }

    Residual residual(const Sample& sample,
                      const Eigen::Isometry3d& T_after_before,
                      const RangeUnknowns& values) const {
        return rig_.focal_px * (corrected(sample.after, values) -
                                seen_after(corrected(sample.before, values), T_after_before));
    }

    // Returns the lower factor of the residual's covariance for noise of 1 px in all that was
    // measured but the first pixel, which chose the point.
    Eigen::Matrix3d noise_factor(const Sample& sample, const Window& window) const {
        Eigen::Vector3d before = corrected(sample.before, values_);
        constexpr double kStep = 1e-5;
        const Eigen::Vector3d at = seen_after(before, window.T_after_before);
        before.z() += kStep;
        const Eigen::Vector3d by_disparity =
            (seen_after(before, window.T_after_before) - at) / kStep;
        Eigen::Matrix3d covariance = by_disparity * by_disparity.transpose();
        covariance += Eigen::Matrix3d::Identity();
        return covariance.llt().matrixL();
    }

    static Eigen::Isometry3d moved(const Eigen::Isometry3d& T, const AllUnknowns& step) {
        Eigen::Isometry3d result = T;
        result.linear() =
            base::rotation_from_vector(step.head<3>()).toRotationMatrix() * T.linear();
        result.translation() += step.segment<3>(3);
        return result;
    }

    static constexpr double kPerturbation = 1e-6;
    Moved moved(const Window& window, const AllUnknowns& step) const {
        return {moved(window.T_after_before, step), values_ + scaled(step)};
    }

    // Returns where a window's unknowns are, and where a small step in each would take them.
    MovedByEach moved_by_each(const Window& window) const {
        MovedByEach result;
        result.here = moved(window, AllUnknowns::Zero());
        for (int k = 0; k < kNumAll; ++k)
            result.there[static_cast<std::size_t>(k)] =
                moved(window, kPerturbation * AllUnknowns::Unit(k));
        return result;
    }

    Linearised linearised(const Sample& sample,
                          const Window& window,
                          const MovedByEach& steps) const {
        const auto factor = noise_factor(sample, window);
        const auto whitened = [&](const Moved& to) -> Residual {
            return factor.triangularView<Eigen::Lower>().solve(
                residual(sample, to.T_after_before, to.values));
        };
        Linearised result;
        result.residual = whitened(steps.here);
        for (int k = 0; k < kNumAll; ++k)
            result.jacobian.col(k) =
                (whitened(steps.there[static_cast<std::size_t>(k)]) - result.residual) /
                kPerturbation;
        return result;
    }

    // The shared part of a step; the principal point is in focal lengths there.
    RangeUnknowns scaled(const AllUnknowns& step) const {
        RangeUnknowns shared = step.tail<kNumRangeUnknowns>();
        shared[1] *= rig_.focal_px;
        return shared;
    }

    // Returns the norms of the whitened residuals, px.
    std::vector<double> norms() const {
        std::vector<double> norms;
        for (const Window& window : windows_)
            for (const Sample& sample : window.samples) norms.push_back(norm_of(sample, window));
        return norms;
    }

    // Returns the robust loss of residuals at the present scale, with that of the prior.
    double cost(const std::vector<double>& norms, const RangeUnknowns& values) const {
        double sum = 0.0;
        for (const double norm : norms) sum += stats::tukey_loss(norm / error_px_, stats::kTukey);
        return sum + 0.5 * (values - prior_).cwiseQuotient(prior_sigmas_).squaredNorm();
    }

    void reweight() {
        const std::vector<double> norms = this->norms();
        if (norms.empty()) return;
        error_px_ = std::max(kMinError_px, stats::upper_median(norms) / stats::kMedianNormOfThree);
        auto norm = norms.begin();
        for (Window& window : windows_)
            for (double& weight : window.weights)
                weight = stats::tukey_weight(*norm++, stats::kTukey * error_px_);
    }

    double norm_of(const Sample& sample, const Window& window) const {
        return noise_factor(sample, window)
            .triangularView<Eigen::Lower>()
            .solve(residual(sample, window.T_after_before, values_))
            .norm();
    }

    WindowEquations equations(const Window& window) const {
        WindowEquations result;
        const MovedByEach steps = moved_by_each(window);
        for (std::size_t i = 0; i < window.samples.size(); ++i) {
            if (window.weights[i] <= 0.0) continue;
            const Linearised at = linearised(window.samples[i], window, steps);
            const double weight = window.weights[i] / (error_px_ * error_px_);
            result.information += weight * at.jacobian.transpose() * at.jacobian;
            result.gradient += weight * at.jacobian.transpose() * at.residual;
        }
        result.information.diagonal().head<kNumPose>().array() += 1e-6;
        return result;
    }

    Eigen::Matrix<double, kNumRangeUnknowns, kNumPose> elimination(
        const WindowEquations& of) const {
        return of.information.topLeftCorner<kNumPose, kNumPose>()
            .ldlt()
            .solve(Eigen::Matrix<double, kNumPose, kNumRangeUnknowns>(
                of.information.topRightCorner<kNumPose, kNumRangeUnknowns>()))
            .transpose();
    }

    Reduced reduced(const std::vector<WindowEquations>& all) const {
        Reduced result;
        for (const WindowEquations& of : all) {
            const auto gain = elimination(of);
            const RangeUnknowns gradient =
                of.gradient.tail<kNumRangeUnknowns>() - gain * of.gradient.head<kNumPose>();
            result.information +=
                of.information.bottomRightCorner<kNumRangeUnknowns, kNumRangeUnknowns>() -
                gain * of.information.topRightCorner<kNumPose, kNumRangeUnknowns>();
            result.gradient += gradient;
            result.between_windows += gradient * gradient.transpose();
        }
        const double share = std::min(1.0, static_cast<double>(all.size()) / kWindowsThatTell);
        result.information *= share;
        result.gradient *= share;
        result.between_windows *= share;
        RangeUnknowns sigmas = prior_sigmas_;
        RangeUnknowns off = values_ - prior_;
        sigmas[1] /= rig_.focal_px;
        off[1] /= rig_.focal_px;
        const RangeUnknowns weight = sigmas.cwiseAbs2().cwiseInverse();
        result.information.diagonal() += weight;
        result.gradient += weight.cwiseProduct(off);
        return result;
    }

    std::vector<WindowEquations> all_equations() const {
        std::vector<WindowEquations> all;
        for (const Window& window : windows_) all.push_back(equations(window));
        return all;
    }

    // Returns how far it moved the shared unknowns, RMS of their sigmas.
    double step() {
        const std::vector<WindowEquations> all = all_equations();
        const Reduced shared = reduced(all);
        AllUnknowns step = AllUnknowns::Zero();
        step.tail<kNumRangeUnknowns>() = -shared.information.ldlt().solve(shared.gradient);
        for (std::size_t w = 0; w < windows_.size(); ++w) {
            const auto& of = all[w];
            step.head<kNumPose>() =
                -of.information.topLeftCorner<kNumPose, kNumPose>().ldlt().solve(
                    Eigen::Matrix<double, kNumPose, 1>(
                        of.gradient.head<kNumPose>() +
                        of.information.topRightCorner<kNumPose, kNumRangeUnknowns>() *
                            step.tail<kNumRangeUnknowns>()));
            windows_[w].T_after_before = moved(windows_[w].T_after_before, step);
        }
        values_ += scaled(step);
        const RangeUnknowns moved = step.tail<kNumRangeUnknowns>();
        return std::sqrt(moved.dot(shared.information * moved) / kNumRangeUnknowns);
    }

    RangeSolution solution() const {
        RangeSolution result;
        result.values = values_;
        result.error_px = error_px_;
        result.num_windows = static_cast<int>(windows_.size());
        for (const Window& window : windows_)
            result.num_matches += static_cast<int>(
                std::ranges::count_if(window.weights, [](double weight) { return weight > 0.0; }));
        const Reduced shared = reduced(all_equations());
        const RangeCovariance inverse = shared.information.inverse();
        result.covariance = inverse + inverse * shared.between_windows * inverse;
        RangeUnknowns by_bias = RangeUnknowns::Zero();
        by_bias << rig_.focal_px, -rig_.focal_px, 0.0, 0.0;
        result.bias_sigma_px = std::sqrt(by_bias.dot(result.covariance * by_bias));
        result.bias_px = rig_.focal_px * values_[0] - values_[1];
        result.covariance.row(1) *= rig_.focal_px;
        result.covariance.col(1) *= rig_.focal_px;
        return result;
    }

    types::RectifiedRig rig_;
    RangeUnknowns prior_;
    RangeUnknowns prior_sigmas_;
    RangeUnknowns values_;
    double error_px_ = 1.0;
    std::vector<Window> windows_;
};

}  // namespace

RangeSolution solve_ranges(const types::RectifiedRig& rig,
                           const std::vector<RangeWindow>& windows,
                           const RangeUnknowns& prior,
                           const RangeUnknowns& prior_sigmas) {
    return RangeProblem(rig, windows, prior, prior_sigmas).solve();
}

}  // namespace divemesh::calibration
