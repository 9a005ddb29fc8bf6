#include "worker/stats/estimate.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "worker/stats/distributions.hpp"
#include "worker/stats/summary.hpp"

namespace divemesh::stats {
namespace {

double variance_of(const std::vector<double>& values, double mean) {
    double squares = 0.0;
    for (const double value : values) squares += (value - mean) * (value - mean);
    return squares / static_cast<double>(values.size() - 1);
}

// Returns the standard deviation of the metric. The effect of added noise varies more than that of
// the noise already there, so the replicates' variance is extrapolated to -1 times the added
// variance, by a parabola through 0 (Stefanski and Cook 1995). For a metric quadratic in the noise
// a third of it is left, for a linear one all of it.
double deviation_of(const Simulated& simulated, double once, double twice) {
    const double variance_once = variance_of(simulated.once, once);
    const double variance_twice = variance_of(simulated.twice, twice);
    return std::sqrt(
        std::clamp(3.0 * variance_once - variance_twice, variance_once / 3.0, variance_once));
}

}  // namespace

double sharpened(double measured, double blurred, double blurred_twice) {
    const double first = measured - blurred;
    if (first == 0.0 || !std::isfinite(first)) return measured;
    const double next = (blurred - blurred_twice) / first;
    return measured + first * (2.0 - std::clamp(std::isfinite(next) ? next : 1.0, 0.0, 1.0));
}

Estimate with_shared_error(const Estimate& estimate, double relative_sigma) {
    const double half_width = kNormal975 * relative_sigma * estimate.value;
    return {estimate.value,
            estimate.value - std::hypot(estimate.value - estimate.low, half_width),
            estimate.value + std::hypot(estimate.high - estimate.value, half_width)};
}

Estimate estimate(const Simulated& simulated,
                  double sigma_relative_error,
                  const SharedError& shared) {
    double noise = 0.0;  // its effect on the metric
    double half_width = 0.0;
    if (simulated.once.size() > 1) {
        const double once = mean(simulated.once);
        const double twice = mean(simulated.twice);
        noise = 3.0 * once - 2.0 * simulated.sharp - twice;
        half_width = student_t_quantile(0.975, static_cast<double>(simulated.once.size() - 1)) *
                     deviation_of(simulated, once, twice);
    }
    const double value = simulated.sharp - noise;
    const Eigen::Vector4d systematic(2.0 * sigma_relative_error * noise,
                                     simulated.sharp - simulated.measured,
                                     shared.relative * value,
                                     shared.absolute);
    half_width = std::hypot(half_width, kNormal975 * systematic.norm());
    return {value, value - half_width, value + half_width};
}

}  // namespace divemesh::stats
