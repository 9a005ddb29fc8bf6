#include "worker/color/fit_problem.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "worker/color/fit_priors.hpp"
#include "worker/stats/median.hpp"
#include "worker/stats/robust.hpp"

namespace divemesh::color {
namespace {

// The right model takes 8 to 25 steps on simulated dives, a wrong one may wander along a valley.
constexpr int kMaxSteps = 40;
constexpr int kNoiseSteps = 20;  // in which the noise follows, so that later ones have one loss
// How far the minimum may be, in standard deviations of each unknown: too little to be seen.
constexpr double kConverged = 1e-2;
constexpr double kMaxDamping = 1e6;  // steps are then too short to matter
constexpr double kMinNoise = 0.02;   // times that of a sighting: of images without noise

}  // namespace

FitProblem::FitProblem(const Sightings& sightings, int num_threads)
    : sightings_(sightings), num_threads_(num_threads), begin_(sightings.num_points + 1, 0) {
    for (const Sighting& sighting : sightings.all) ++begin_[sighting.point + 1];
    for (std::size_t i = 0; i < sightings.num_points; ++i) begin_[i + 1] += begin_[i];
}

FitSolution FitProblem::solve(const FitModel& model,
                              const WaterUnknowns& start,
                              const base::ProgressShare& progress) const {
    State state;
    state.unknowns = start;
    const FitColumns columns(model, start.log_gains.size());
    start_colors(model, state);
    double damping = 1e-3;
    for (int i = 0; i < kMaxSteps; ++i) {
        progress.at(static_cast<double>(i) / kMaxSteps);
        if (i < kNoiseSteps) estimate_noise(model, state);
        weigh(model, state);
        solve_colors(model, state);
        const StepEnd end = step(model, columns, damping, state);
        if (end == StepEnd::Lower) continue;
        state.has_converged = end == StepEnd::Converged;
        break;
    }
    set_covariances(model, columns, state);
    return std::move(static_cast<FitSolution&>(state));
}

FitProblem::StepEnd FitProblem::step(const FitModel& model,
                                     const FitColumns& columns,
                                     double& damping,
                                     State& state) const {
    NormalEquations equations = this->equations(model, state, columns);
    FitPriors(model, columns, state.unknowns).add_to(equations);
    for (const int column : columns_at_bounds(state.unknowns, columns, equations.b))
        equations.hold(column);
    const double ahead = equations.H.ldlt().solve(equations.b).dot(equations.b);
    if (ahead <= kConverged * kConverged * static_cast<double>(columns.num))
        return StepEnd::Converged;
    const double before = weighted_loss(model, columns, state);
    for (; damping < kMaxDamping; damping *= 10.0) {
        Eigen::MatrixXd damped = equations.H;
        damped.diagonal() *= 1.0 + damping;
        const Eigen::VectorXd step = damped.ldlt().solve(equations.b);
        if (!step.allFinite()) continue;
        State trial = state;
        add_step(columns, step, trial.unknowns);
        solve_colors(model, trial);
        if (!(weighted_loss(model, columns, trial) <= before)) continue;  // NaN too
        state = std::move(trial);
        damping = std::max(1e-9, 0.1 * damping);
        return StepEnd::Lower;
    }
    return StepEnd::Stalled;
}

void FitProblem::for_each_sighting(const std::function<void(std::size_t)>& visit) const {
    base::for_each_index(num_threads_, kNumParts, [&](std::size_t part) {
        const std::size_t end = (part + 1) * sightings_.all.size() / kNumParts;
        for (std::size_t i = part * sightings_.all.size() / kNumParts; i < end; ++i) visit(i);
    });
}

void FitProblem::for_each_point(const std::function<void(std::size_t, std::size_t)>& visit) const {
    base::for_each_index(num_threads_, kNumParts, [&](std::size_t part) {
        const std::size_t end = (part + 1) * sightings_.num_points / kNumParts;
        for (std::size_t p = part * sightings_.num_points / kNumParts; p < end; ++p) visit(part, p);
    });
}

Prediction FitProblem::predicted(const FitModel& model,
                                 const FitSolution& solution,
                                 std::size_t sighting,
                                 std::size_t channel,
                                 double color) const {
    const Sighting& seen = sightings_.all[sighting];
    const WaterUnknowns& unknowns = solution.unknowns;
    return predict(model,
                   unknowns.channels[channel],
                   std::exp(unknowns.log_gain(seen.keyframe, sightings_.num_keyframes)),
                   unknowns.vignetting,
                   seen,
                   color);
}

// Returns by how much a sighting exceeds the model, and its unscaled standard deviation.
double FitProblem::error(const FitModel& model,
                         const FitSolution& solution,
                         std::size_t sighting,
                         std::size_t channel,
                         double& sigma) const {
    const Sighting& seen = sightings_.all[sighting];
    const double light =
        predicted(model, solution, sighting, channel, solution.colors[seen.point][channel]).value;
    sigma = std::sqrt(kDarkNoise * kDarkNoise + kNoiseShare * kNoiseShare * light * light);
    return static_cast<double>(seen.rgb[channel]) - light;
}

// Starts with the median of the colours that the sightings of a point would give it.
void FitProblem::start_colors(const FitModel& model, State& state) const {
    state.colors.assign(sightings_.num_points, {});
    base::for_each_index(num_threads_, sightings_.num_points, [&](std::size_t point) {
        for (std::size_t channel = 0; channel < 3; ++channel) {
            std::vector<double> colors;
            for (std::size_t i = begin_[point]; i < begin_[point + 1]; ++i) {
                const Prediction dark = predicted(model, state, i, channel, 0.0);
                const double light =
                    static_cast<double>(sightings_.all[i].rgb[channel]) - dark.value;
                if (dark.by_color > 0.0) colors.push_back(std::max(0.0, light / dark.by_color));
            }
            state.colors[point][channel] = stats::median(std::move(colors));
        }
    });
}

void FitProblem::estimate_noise(const FitModel& model, State& state) const {
    for (std::size_t channel = 0; channel < 3; ++channel) {
        std::vector<double> sizes(sightings_.all.size());
        for_each_sighting([&](std::size_t i) {
            double sigma = 0.0;
            const double excess = error(model, state, i, channel, sigma);
            sizes[i] = std::abs(excess) / sigma;
        });
        state.noise[channel] =
            std::max(kMinNoise, stats::kSigmasPerMad * stats::median(std::move(sizes)));
    }
}

void FitProblem::weigh(const FitModel& model, State& state) const {
    state.weights.resize(sightings_.all.size());
    for_each_sighting([&](std::size_t i) {
        for (std::size_t channel = 0; channel < 3; ++channel) {
            double sigma = 0.0;
            const double excess = error(model, state, i, channel, sigma);
            sigma *= state.noise[channel];
            state.weights[i][channel] =
                stats::tukey_weight(excess / sigma, stats::kTukey) / (sigma * sigma);
        }
    });
}

void FitProblem::solve_colors(const FitModel& model, State& state) const {
    base::for_each_index(num_threads_, sightings_.num_points, [&](std::size_t point) {
        for (std::size_t channel = 0; channel < 3; ++channel) {
            double sum = 0.0;
            double squared = 0.0;
            for (std::size_t i = begin_[point]; i < begin_[point + 1]; ++i) {
                const Prediction dark = predicted(model, state, i, channel, 0.0);
                const double weighted = state.weights[i][channel] * dark.by_color;
                sum +=
                    weighted * (static_cast<double>(sightings_.all[i].rgb[channel]) - dark.value);
                squared += weighted * dark.by_color;
            }
            if (squared > 0.0) state.colors[point][channel] = std::max(0.0, sum / squared);
        }
    });
}

double FitProblem::weighted_loss(const FitModel& model,
                                 const FitColumns& columns,
                                 const State& state) const {
    std::vector<double> losses(sightings_.all.size(), 0.0);
    for_each_sighting([&](std::size_t i) {
        for (std::size_t channel = 0; channel < 3; ++channel) {
            double sigma = 0.0;
            const double excess = error(model, state, i, channel, sigma);
            losses[i] += state.weights[i][channel] * excess * excess;
        }
    });
    double sum = FitPriors(model, columns, state.unknowns).loss();
    for (const double loss : losses) sum += loss;
    return sum;
}

PointEquations FitProblem::equations_of(const FitModel& model,
                                        const State& state,
                                        const FitColumns& columns,
                                        std::size_t point,
                                        std::size_t channel) const {
    PointEquations equations;
    for (std::size_t i = begin_[point]; i < begin_[point + 1]; ++i) {
        const double weight = state.weights[i][channel];
        if (weight <= 0.0) continue;
        const Sighting& seen = sightings_.all[i];
        const Prediction prediction =
            predicted(model, state, i, channel, state.colors[point][channel]);
        const auto gain = state.unknowns.gain_place(seen.keyframe, sightings_.num_keyframes);
        equations.add(prediction,
                      static_cast<double>(seen.rgb[channel]) - prediction.value,
                      weight,
                      columns.gains + static_cast<int>(gain.knot),
                      gain.share);
    }
    if (state.colors[point][channel] <= 0.0) equations.bound_color();
    return equations;
}

NormalEquations FitProblem::equations(const FitModel& model,
                                      const State& state,
                                      const FitColumns& columns) const {
    std::vector<NormalEquations> parts(kNumParts, NormalEquations(columns.num));
    for_each_point([&](std::size_t part, std::size_t point) {
        for (std::size_t channel = 0; channel < 3; ++channel)
            equations_of(model, state, columns, point, channel)
                .add_to(parts[part], columns.shared[channel]);
    });
    NormalEquations sum = std::move(parts[0]);
    for (std::size_t part = 1; part < kNumParts; ++part) {
        sum.H += parts[part].H;
        sum.b += parts[part].b;
    }
    return sum;
}

double FitProblem::loss(const FitModel& model,
                        const FitSolution& solution,
                        const std::array<double, 3>& noise) const {
    std::vector<double> losses(sightings_.all.size(), 0.0);
    for_each_sighting([&](std::size_t i) {
        for (std::size_t channel = 0; channel < 3; ++channel) {
            double sigma = 0.0;
            const double excess = error(model, solution, i, channel, sigma);
            losses[i] += stats::tukey_loss(excess / (sigma * noise[channel]), stats::kTukey);
        }
    });
    double sum = 0.0;
    for (const double loss : losses) sum += loss;
    return sum / static_cast<double>(losses.size());
}

std::vector<double> FitProblem::log_residuals(const FitModel& model,
                                              const FitSolution& solution,
                                              std::size_t channel) const {
    std::vector<double> residuals;
    for (std::size_t i = 0; i < sightings_.all.size(); ++i) {
        const Sighting& seen = sightings_.all[i];
        const double light =
            predicted(model, solution, i, channel, solution.colors[seen.point][channel]).value;
        const double observed = static_cast<double>(seen.rgb[channel]);
        if (observed > kMinLight)
            residuals.push_back(std::log(observed / std::max(0.1 * kMinLight, light)));
    }
    return residuals;
}

}  // namespace divemesh::color
