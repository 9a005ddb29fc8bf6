#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "worker/color/fit_priors.hpp"
#include "worker/color/fit_problem.hpp"
#include "worker/stats/robust.hpp"

// The covariance of the unknowns of a solved problem.
namespace divemesh::color {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Returns the derivative of Tukey's weight times residual.
double tukey_slope(double residual) {
    const double squared = residual * residual / (stats::kTukey * stats::kTukey);
    return squared >= 1.0 ? 0.0 : (1.0 - squared) * (1.0 - 5.0 * squared);
}

}  // namespace

double FitSolution::sigma(std::size_t channel, const Eigen::Vector4d& gradient) const {
    const double variance = gradient.dot(covariances[channel] * gradient);
    return std::isfinite(variance) && variance >= 0.0 ? std::sqrt(variance) : kInfinity;
}

// Returns the sum of the weights over that of the slopes of the influence function, of each
// channel: an M-estimator is as much less certain than its weights say (Huber, "Robust
// Statistics", 1981, section 7.6).
std::array<double, 3> FitProblem::huber_factors(const FitModel& model, const State& state) const {
    std::vector<std::array<double, 3>> weights(sightings_.all.size());
    std::vector<std::array<double, 3>> slopes(sightings_.all.size());
    for_each_sighting([&](std::size_t i) {
        for (std::size_t channel = 0; channel < 3; ++channel) {
            double sigma = 0.0;
            const double residual =
                error(model, state, i, channel, sigma) / (sigma * state.noise[channel]);
            weights[i][channel] = stats::tukey_weight(residual, stats::kTukey);
            slopes[i][channel] = tukey_slope(residual);
        }
    });
    std::array<double, 3> factors = {};
    for (std::size_t channel = 0; channel < 3; ++channel) {
        double weight = 0.0;
        double slope = 0.0;
        for (std::size_t i = 0; i < weights.size(); ++i) {
            weight += weights[i][channel];
            slope += slopes[i][channel];
        }
        factors[channel] = slope > 0.0 ? weight / slope : kInfinity;
    }
    return factors;
}

// Returns the covariance of the channels' unknowns and vignetting, while the unknowns in the
// columns `held` stay as they are. The errors are shared within each point: a sandwich by clusters
// (Liang and Zeger, "Longitudinal data analysis using generalized linear models", 1986).
Eigen::MatrixXd FitProblem::covariance(const FitModel& model,
                                       const FitColumns& columns,
                                       const State& state,
                                       const std::array<double, 3>& factors,
                                       const std::vector<int>& held) const {
    NormalEquations priors(columns.num);
    FitPriors(model, columns, state.unknowns).add_to(priors);
    NormalEquations all = equations(model, state, columns);
    all.H += priors.H;
    for (const int column : held) all.hold(column);
    const Eigen::Index num = columns.gains;  // the gains are not needed
    Eigen::MatrixXd rows =
        all.H.ldlt().solve(Eigen::MatrixXd::Identity(columns.num, num)).transpose();
    for (const int column : held) rows.row(column).setZero();
    for (const int column : held) rows.col(column).setZero();
    std::vector<Eigen::MatrixXd> parts(kNumParts, Eigen::MatrixXd::Zero(num, num));
    for_each_point([&](std::size_t part, std::size_t point) {
        Eigen::VectorXd change = Eigen::VectorXd::Zero(num);
        for (std::size_t channel = 0; channel < 3; ++channel)
            equations_of(model, state, columns, point, channel)
                .add_projected(rows, columns.shared[channel], factors[channel], change);
        parts[part] += change * change.transpose();
    });
    Eigen::MatrixXd sum = rows * priors.H * rows.transpose();
    for (const Eigen::MatrixXd& part : parts) sum += part;
    return sum;
}

// Unknowns at a bound do not make the others uncertain, but are as uncertain themselves as if they
// were free.
void FitProblem::set_covariances(const FitModel& model,
                                 const FitColumns& columns,
                                 State& state) const {
    NormalEquations all = equations(model, state, columns);
    FitPriors(model, columns, state.unknowns).add_to(all);
    const std::vector<int> held = columns_at_bounds(state.unknowns, columns, all.b);
    const std::array<double, 3> factors = huber_factors(model, state);
    Eigen::MatrixXd known = covariance(model, columns, state, factors, held);
    if (!held.empty()) {
        const Eigen::MatrixXd free = covariance(model, columns, state, factors, {});
        for (const int column : held) known(column, column) = free(column, column);
    }
    for (std::size_t c = 0; c < state.covariances.size(); ++c) {
        state.covariances[c].setZero();
        for (std::size_t i = 0; i < ChannelUnknowns::kSize; ++i)
            for (std::size_t j = 0; j < ChannelUnknowns::kSize; ++j) {
                const int row = columns.shared[c][i];
                const int column = columns.shared[c][j];
                if (row == FitColumns::kNone || column == FitColumns::kNone) continue;
                state.covariances[c](static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
                    known(row, column);
            }
    }
}

}  // namespace divemesh::color
