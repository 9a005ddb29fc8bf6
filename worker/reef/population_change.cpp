#include "worker/reef/population_change.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/reef/population.hpp"
#include "worker/stats/distributions.hpp"
#include "worker/stats/quantile.hpp"
#include "worker/stats/resample.hpp"

namespace divemesh::reef {
namespace {

double median_or_nan(std::vector<double>& sizes) {
    if (sizes.empty()) return std::numeric_limits<double>::quiet_NaN();
    std::sort(sizes.begin(), sizes.end());
    return stats::quantile_of_sorted(sizes, 0.5);
}

}  // namespace

stats::Estimate count_change(const std::vector<Individual>& individuals) {
    const auto num = [&](bool is_new) {
        return static_cast<std::size_t>(std::count_if(
            individuals.begin(), individuals.end(), [&](const Individual& individual) {
                return is_new ? !individual.before && individual.after
                              : individual.before && !individual.after;
            }));
    };
    const stats::Estimate added = poisson_count(num(true));
    const stats::Estimate gone = poisson_count(num(false));
    const double value = added.value - gone.value;
    return {value,
            value - std::hypot(added.value - added.low, gone.high - gone.value),
            value + std::hypot(added.high - added.value, gone.value - gone.low)};
}

stats::Estimate sum_change(const std::vector<Individual>& individuals) {
    double sum = 0.0;
    double squares = 0.0;
    for (const Individual& individual : individuals) {
        const double difference = individual.after.value_or(0.0) - individual.before.value_or(0.0);
        sum += difference;
        squares += difference * difference;
    }
    const double half = stats::kNormal975 * std::sqrt(squares);
    return {sum, sum - half, sum + half};
}

std::optional<stats::Estimate> median_change(const std::vector<Individual>& individuals,
                                             std::uint64_t seed) {
    std::vector<double> before;
    std::vector<double> after;
    const auto difference = [&](const std::vector<std::size_t>& drawn) {
        before.clear();
        after.clear();
        for (const std::size_t i : drawn) {
            if (individuals[i].before) before.push_back(*individuals[i].before);
            if (individuals[i].after) after.push_back(*individuals[i].after);
        }
        return median_or_nan(after) - median_or_nan(before);
    };
    if (individuals.empty()) return std::nullopt;
    const stats::Estimate change = stats::bootstrap(individuals.size(), difference, seed);
    if (change.value != change.value) return std::nullopt;
    return change;
}

}  // namespace divemesh::reef
