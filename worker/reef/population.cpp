#include "worker/reef/population.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "worker/stats/resample.hpp"
#include "worker/stats/distributions.hpp"
#include "worker/stats/quantile.hpp"

namespace divemesh::worker {

Estimate poisson_count(std::size_t num) {
    const auto count = static_cast<double>(num);
    return {count,
            num > 0 ? 0.5 * chi_square_quantile(0.025, 2.0 * count) : 0.0,
            0.5 * chi_square_quantile(0.975, 2.0 * count + 2.0)};
}

Estimate density_per_m2(const Population& population) {
    const Estimate count = poisson_count(population.areas_m2.size());
    return {count.value / population.surveyed_m2,
            count.low / population.surveyed_m2,
            count.high / population.surveyed_m2};
}

Estimate cover(const Population& population) {
    const std::vector<double>& areas = population.areas_m2;
    const double sum = std::accumulate(areas.begin(), areas.end(), 0.0);
    const double deviation =
        std::sqrt(std::inner_product(areas.begin(), areas.end(), areas.begin(), 0.0));
    return {sum / population.surveyed_m2,
            std::max(0.0, sum - kNormal975 * deviation) / population.surveyed_m2,
            (sum + kNormal975 * deviation) / population.surveyed_m2};
}

Estimate size_quantile(const std::vector<double>& sizes, double share, std::uint64_t seed) {
    std::vector<double> drawn;
    return bootstrap(
        sizes.size(),
        [&](const std::vector<std::size_t>& individuals) {
            drawn.clear();
            for (const std::size_t i : individuals) drawn.push_back(sizes[i]);
            std::sort(drawn.begin(), drawn.end());
            return quantile_of_sorted(drawn, share);
        },
        seed);
}

}  // namespace divemesh::worker
