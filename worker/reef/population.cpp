#include "worker/reef/population.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "worker/stats/distributions.hpp"
#include "worker/stats/quantile.hpp"
#include "worker/stats/resample.hpp"

namespace divemesh::reef {

stats::Estimate poisson_count(std::size_t num) {
    const auto count = static_cast<double>(num);
    return {count,
            num > 0 ? 0.5 * stats::chi_square_quantile(0.025, 2.0 * count) : 0.0,
            0.5 * stats::chi_square_quantile(0.975, 2.0 * count + 2.0)};
}

stats::Estimate density_per_m2(const Population& population) {
    const stats::Estimate count = poisson_count(population.areas_m2.size());
    return {count.value / population.surveyed_m2,
            count.low / population.surveyed_m2,
            count.high / population.surveyed_m2};
}

stats::Estimate cover(const Population& population) {
    const std::vector<double>& areas = population.areas_m2;
    const double sum = std::accumulate(areas.begin(), areas.end(), 0.0);
    const double deviation =
        std::sqrt(std::inner_product(areas.begin(), areas.end(), areas.begin(), 0.0));
    return {sum / population.surveyed_m2,
            std::max(0.0, sum - stats::kNormal975 * deviation) / population.surveyed_m2,
            (sum + stats::kNormal975 * deviation) / population.surveyed_m2};
}

stats::Estimate size_quantile(const std::vector<double>& sizes, double share, std::uint64_t seed) {
    std::vector<double> drawn;
    return stats::bootstrap(
        sizes.size(),
        [&](const std::vector<std::size_t>& individuals) {
            drawn.clear();
            for (const std::size_t i : individuals) drawn.push_back(sizes[i]);
            std::sort(drawn.begin(), drawn.end());
            return stats::quantile_of_sorted(drawn, share);
        },
        seed);
}

}  // namespace divemesh::reef
