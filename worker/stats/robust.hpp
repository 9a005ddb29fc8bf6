#pragma once

#include <cmath>

// Robust estimation of a scale, and weights by it.
namespace divemesh::stats {

// The standard deviation of normal values in their median absolute deviations.
inline constexpr double kSigmasPerMad = 1.482602218505602;
// The median norm of three independent standard normal values: the root of the median of chi-square
// with three degrees of freedom.
inline constexpr double kMedianNormOfThree = 1.5381722544550522;
// The limit of Tukey's biweight in standard deviations at which it is 95 % efficient for normal
// errors.
inline constexpr double kTukey = 4.685;

// Returns Tukey's biweight of a residual, which is 0 from `limit` on (Beaton and Tukey 1974).
inline double tukey_weight(double residual, double limit) {
    const double share = residual / limit;
    if (std::abs(share) >= 1.0) return 0.0;
    return (1.0 - share * share) * (1.0 - share * share);
}

// Returns Tukey's biweight loss, whose derivative is weight times residual: half of the squared
// residual where that is small.
inline double tukey_loss(double residual, double limit) {
    const double share = residual / limit;
    if (std::abs(share) >= 1.0) return limit * limit / 6.0;
    const double rest = 1.0 - share * share;
    return limit * limit / 6.0 * (1.0 - rest * rest * rest);
}

}  // namespace divemesh::stats
