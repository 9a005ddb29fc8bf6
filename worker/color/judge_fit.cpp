#include "worker/color/judge_fit.hpp"

#include <algorithm>
#include <cmath>

namespace divemesh::color {
namespace {

// What the water must take over the ranges of a dive, at least in one channel: chosen;
// 5 % of light is 1.5 levels at level 65.
constexpr double kMinEffect = 0.05;
constexpr double kMinSigmas = 3.0;
// How uncertain a restored colour may be by attenuation over the ranges of a dive, one sigma: 50 %.
constexpr double kMaxColorSigma = 0.5;
// How uncertain backscatter may be at the far end, one sigma, as a share of the light there.
constexpr double kMaxBackscatterSigma = 0.2;
// A third of the prior's sigma, so that it is the sightings that tell.
constexpr double kMaxSigma_per_m = 1.0;
constexpr double kMinLitShare = 0.1;   // of the sightings: those from near, where red is left
constexpr double kMinExplained = 0.1;  // of the variance: chosen, as less may be chance or caustics

// Returns the light of a surface of that colour at the far end.
double far_light(const ColorFit& fit, const ChannelFit& channel, double color) {
    const DirectShare share = direct_share(channel, fit.light, fit.far_m);
    return color * (share.sky + share.lamps) + backscatter(channel, fit.far_m);
}

bool is_known(const ColorFit& fit, const FitEvidence& evidence, std::size_t c) {
    const ChannelFit& channel = fit.channels[c];
    const double sigma_per_m = channel.attenuation_per_m.sigma;
    return evidence.lit_share[c] >= kMinLitShare &&
           std::isfinite(channel.attenuation_per_m.value) && sigma_per_m <= kMaxSigma_per_m &&
           sigma_per_m * (fit.far_m - fit.near_m) <= kMaxColorSigma &&
           channel.far_backscatter_sigma <=
               kMaxBackscatterSigma * far_light(fit, channel, evidence.median_color[c]);
}

bool has_effect(const Value& attenuation, double over_m) {
    return attenuation.value * over_m > kMinEffect &&
           attenuation.value > kMinSigmas * attenuation.sigma;
}

// Returns whether light grows on its way, as no water makes it.
bool is_negative(const Value& attenuation, double over_m) {
    return (attenuation.value + kMinSigmas * attenuation.sigma) * over_m < -kMinEffect;
}

FitOutcome outcome_of(const FitEvidence& evidence, const ColorFit& fit) {
    const double over_m = fit.far_m - fit.near_m;
    std::size_t num_known = 0;
    std::size_t num_lit = 0;
    bool has_any_effect = false;
    bool is_any_negative = false;
    bool is_any_at_bound = false;
    for (std::size_t c = 0; c < fit.channels.size(); ++c) {
        const ChannelFit& channel = fit.channels[c];
        if (evidence.lit_share[c] >= kMinLitShare) ++num_lit;
        if (!channel.known) continue;
        ++num_known;
        has_any_effect = has_any_effect || has_effect(channel.attenuation_per_m, over_m);
        is_any_negative = is_any_negative || is_negative(channel.attenuation_per_m, over_m);
        is_any_at_bound = is_any_at_bound || evidence.is_at_bound[c];
    }
    if (is_any_negative) return FitOutcome::NotExplained;
    if (!evidence.has_converged || is_any_at_bound) return FitOutcome::NotConverged;
    if (num_known == 0 && num_lit > 0) return FitOutcome::TooLittleRange;
    if (num_known < fit.channels.size())
        return num_lit == fit.channels.size() ? FitOutcome::TooLittleRange
                                              : FitOutcome::ChannelTooDark;
    if (!has_any_effect) return FitOutcome::NothingToRestore;
    return fit.explained_share < kMinExplained ? FitOutcome::NotExplained : FitOutcome::Estimated;
}

}  // namespace

void judge_fit(const FitEvidence& evidence, ColorFit& fit) {
    double sum = 0.0;
    double num_known = 0.0;
    for (std::size_t c = 0; c < fit.channels.size(); ++c) {
        fit.channels[c].known = is_known(fit, evidence, c);
        if (!fit.channels[c].known) continue;
        sum += fit.channels[c].explained_share;
        num_known += 1.0;
    }
    fit.explained_share = sum / std::max(1.0, num_known);
    fit.outcome = outcome_of(evidence, fit);
}

}  // namespace divemesh::color
