#include "tests/bench/calibration_curve.hpp"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <numbers>

#include "worker/stats/distributions.hpp"

namespace divemesh::bench {
namespace {

// Returns the number for which 95 % of sums of squares are below `squared_ratio` times their mean.
double degrees_of_freedom(double squared_ratio) {
    double few = 1.0, many = 1e6;
    for (int halving = 0; halving < 60; ++halving) {
        const double middle = std::sqrt(few * many);
        (stats::chi_square_quantile(0.95, middle) > squared_ratio * middle ? few : many) = middle;
    }
    return many;
}

}  // namespace

void CalibrationCurve::add(std::vector<double> just_held) {
    if (just_held.empty()) return;
    std::sort(just_held.begin(), just_held.end());
    dives_.push_back(std::move(just_held));
}

double CalibrationCurve::held(double level) const {
    double sum = 0.0;
    for (const auto& errors : dives_)
        sum += static_cast<double>(std::upper_bound(errors.begin(), errors.end(), level) -
                                   errors.begin()) /
               static_cast<double>(errors.size());
    return dives_.empty() ? 0.0 : sum / static_cast<double>(dives_.size());
}

nlohmann::json CalibrationCurve::to_json() const {
    nlohmann::json levels = nlohmann::json::array();
    for (const double level : shown_levels())
        levels.push_back({{"stated", level}, {"observed", held(level)}});
    return {{"kind", kind_}, {"num_dives", num_dives()}, {"levels", levels}};
}

const std::vector<double>& shown_levels() {
    static const std::vector<double> levels = {
        0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99};
    return levels;
}

double level_of_normal(double error, double sigma) {
    return std::erf(std::abs(error) / (std::numbers::sqrt2 * sigma));
}

double level_of_length(double length, double root_mean_square, double bound_95) {
    const double freedom = degrees_of_freedom(std::pow(bound_95 / root_mean_square, 2.0));
    return boost::math::cdf(boost::math::chi_squared(freedom),
                            freedom * std::pow(length / root_mean_square, 2.0));
}

}  // namespace divemesh::bench
