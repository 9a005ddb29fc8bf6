#include "worker/color/fit_water.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "worker/color/fit_problem.hpp"
#include "worker/color/judge_fit.hpp"
#include "worker/color/usable_sightings.hpp"
#include "worker/stats/median.hpp"
#include "worker/stats/robust.hpp"

namespace divemesh::color {
namespace {

constexpr std::size_t kMinPoints = 100;  // chosen: of fewer, outliers are too large a part
// Knots of the gains: more would cost more than they tell, as exposure changes slowly.
constexpr std::size_t kMaxKnots = 400;
// How much the ranges of a well seen point must differ at least, as a share of the median range:
// errors of the pose and of shading are as large as the effect of the water over less.
constexpr double kMinSpreadShare = 0.1;

// In how many of its standard deviations the light of lamps must differ from none in a channel at
// least, for the lamps to be believed.
constexpr double kMinLamp_sigmas = 3.0;

// A model with its solution.
struct Candidate {
    FitModel model;
    FitSolution solution;
};

// Returns the part of the progress that one of the five solves has.
base::ProgressShare solve_share(const base::ProgressShare& progress, int solve) {
    constexpr double kNumSolves = 5.0;  // sky, sky with lamps from two starts, lamps, air
    const double each = (progress.end - progress.begin) / kNumSolves;
    return {progress.stage,
            progress.begin + solve * each,
            progress.begin + (solve + 1) * each,
            progress.report};
}

WaterUnknowns start_at(double attenuation_per_m, double lamp, std::size_t num_knots) {
    WaterUnknowns start;
    for (ChannelUnknowns& channel : start.channels)
        channel = {attenuation_per_m, attenuation_per_m, 0.02, lamp};
    start.vignetting = 0.1;
    start.log_gains.assign(num_knots, 0.0);
    return start;
}

// Returns the loss of a candidate for a given noise; a fit that did not converge costs 1 % more.
double cost_of(const FitProblem& problem,
               const Candidate& candidate,
               const std::array<double, 3>& noise) {
    // On the loss: one that converged is preferred unless it is 1 % worse.
    constexpr double kNotConvergedFactor = 1.01;
    const double loss = problem.loss(candidate.model, candidate.solution, noise);
    return candidate.solution.has_converged ? loss : kNotConvergedFactor * loss;
}

bool has_lamps(const FitSolution& mixed) {
    const Eigen::Vector4d lamp = Eigen::Vector4d::Unit(3);
    for (std::size_t c = 0; c < 3; ++c)
        if (mixed.unknowns.channels[c].lamp > kMinLamp_sigmas * mixed.sigma(c, lamp)) return true;
    return false;
}

// Returns the better of two solutions from different starts.
Candidate better_of(const FitProblem& problem, Candidate one, Candidate other) {
    const std::array<double, 3> noise = one.solution.noise;
    return cost_of(problem, other, noise) < cost_of(problem, one, noise) ? std::move(other)
                                                                         : std::move(one);
}

// Returns the model of the light that fits: the sky with lamps if these are significant, else the
// sky alone, which is the same without lamps; or lamps alone if that is better.
Candidate best_model(const FitProblem& problem,
                     std::size_t num_knots,
                     const base::ProgressShare& progress) {
    int num_solved = 0;
    const auto solved = [&](LightSource light, const WaterUnknowns& start) {
        const FitModel model{true, light};
        return Candidate{model, problem.solve(model, start, solve_share(progress, num_solved++))};
    };
    Candidate sky = solved(LightSource::Ambient, start_at(0.3, 0.0, num_knots));
    WaterUnknowns with_lamps = sky.solution.unknowns;
    for (ChannelUnknowns& channel : with_lamps.channels) channel.lamp = 0.3;
    Candidate mixed = solved(LightSource::Mixed, with_lamps);
    Candidate from_lamps = solved(LightSource::Mixed, start_at(0.3, 1.0, num_knots));
    mixed = better_of(problem, std::move(mixed), std::move(from_lamps));
    if (has_lamps(mixed.solution)) sky = std::move(mixed);
    return better_of(
        problem, std::move(sky), solved(LightSource::Camera, start_at(0.3, 0.0, num_knots)));
}

double robust_variance(std::vector<double> residuals) {
    for (double& residual : residuals) residual = std::abs(residual);
    const double sigma = stats::kSigmasPerMad * stats::median(std::move(residuals));
    return sigma * sigma;
}

// Returns the fit with the best model's light, but without water.
Candidate in_air(const FitProblem& problem,
                 const Candidate& best,
                 const base::ProgressShare& progress) {
    const FitModel model{.has_water = false, .light = best.model.light};
    WaterUnknowns start = best.solution.unknowns;
    for (ChannelUnknowns& channel : start.channels)
        channel = {.backscatter_per_m = kChannelBounds[1].min, .lamp = channel.lamp};
    return {model, problem.solve(model, start, progress)};
}

Value value_of(const FitSolution& solution, std::size_t channel, int unknown) {
    return {solution.unknowns.channels[channel][static_cast<std::size_t>(unknown)],
            solution.sigma(channel, Eigen::Vector4d::Unit(unknown))};
}

// Returns the standard deviation of backscatter over a range.
double backscatter_sigma(const FitSolution& solution, std::size_t channel, double range_m) {
    const ChannelUnknowns& water = solution.unknowns.channels[channel];
    const double through = std::exp(-water.backscatter_per_m * range_m);
    return solution.sigma(channel, {0.0, water.veil * range_m * through, 1.0 - through, 0.0});
}

void set_channels(const FitProblem& problem,
                  const Candidate& best,
                  const Candidate& without,
                  ColorFit& fit) {
    for (std::size_t c = 0; c < 3; ++c) {
        ChannelFit& channel = fit.channels[c];
        channel.attenuation_per_m = value_of(best.solution, c, 0);
        channel.backscatter_per_m = value_of(best.solution, c, 1);
        channel.veil = value_of(best.solution, c, 2);
        channel.lamp = value_of(best.solution, c, 3);
        channel.far_backscatter_sigma = backscatter_sigma(best.solution, c, fit.far_m);
        channel.noise = kDarkNoise * best.solution.noise[c];
        const double before =
            robust_variance(problem.log_residuals(without.model, without.solution, c));
        const double after = robust_variance(problem.log_residuals(best.model, best.solution, c));
        channel.explained_share = before > 0.0 ? std::max(0.0, 1.0 - after / before) : 0.0;
    }
}

FitEvidence evidence_of(const Candidate& best, const std::array<double, 3>& lit_share) {
    const WaterUnknowns& unknowns = best.solution.unknowns;
    FitEvidence evidence{.lit_share = lit_share};
    evidence.has_converged = best.solution.has_converged &&
                             unknowns.vignetting > kVignettingBounds.min &&
                             unknowns.vignetting < kVignettingBounds.max;
    for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t i = 0; i < ChannelUnknowns::kSize; ++i)
            if (best.model.has(i) && unknowns.channels[c][i] >= kChannelBounds[i].max)
                evidence.is_at_bound[c] = true;
        std::vector<double> colors;
        colors.reserve(best.solution.colors.size());
        for (const auto& color : best.solution.colors) colors.push_back(color[c]);
        evidence.median_color[c] = stats::median(std::move(colors));
    }
    return evidence;
}

}  // namespace

ColorFit fit_water(const Sightings& sightings,
                   int num_threads,
                   const base::ProgressShare& progress) {
    const Sightings seen = usable_sightings(sightings);
    const std::array<double, 3> lit = lit_shares(seen);
    ColorFit fit;
    fit.num_points = static_cast<std::int64_t>(seen.num_points);
    fit.num_sightings = static_cast<std::int64_t>(seen.all.size());
    fit.log_gains.assign(sightings.num_keyframes, 0.0);
    fit.outcome = FitOutcome::Grey;
    if (is_grey(seen)) return fit;
    fit.outcome = FitOutcome::TooFewSightings;
    if (seen.num_points < kMinPoints) return fit;
    const Ranges ranges = ranges_of(seen);
    fit.near_m = ranges.near_m;
    fit.far_m = ranges.far_m;
    fit.outcome = FitOutcome::ChannelTooDark;
    if (*std::max_element(lit.begin(), lit.end()) <= 0.0) return fit;
    fit.outcome = FitOutcome::TooLittleRange;
    if (ranges.spread_m < kMinSpreadShare * ranges.median_m) return fit;

    const std::size_t num_knots = std::min(kMaxKnots, seen.num_keyframes);
    const FitProblem problem(seen, num_threads);
    const Candidate best = best_model(problem, num_knots, progress);
    fit.light = best.model.light;
    fit.vignetting = best.solution.unknowns.vignetting;
    fit.surface = best.solution.colors;
    for (std::size_t k = 0; k < fit.log_gains.size(); ++k)
        fit.log_gains[k] = best.solution.unknowns.log_gain(k, seen.num_keyframes);
    set_channels(problem, best, in_air(problem, best, solve_share(progress, 4)), fit);
    fit.is_fitted = true;
    judge_fit(evidence_of(best, lit), fit);
    return fit;
}

}  // namespace divemesh::color
