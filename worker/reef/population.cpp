#include "worker/reef/population.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "worker/reef/resample.hpp"

namespace divemesh::worker {
namespace {

constexpr double kTwoSided = 1.959964;

double chi_square_quantile(double degrees_of_freedom, double z) {
    const double part = 2.0 / (9.0 * degrees_of_freedom);
    return degrees_of_freedom * std::pow(1.0 - part + z * std::sqrt(part), 3.0);
}

}  // namespace

Estimate poisson_count(std::size_t num) {
    const auto count = static_cast<double>(num);
    return {count,
            num > 0 ? 0.5 * chi_square_quantile(2.0 * count, -kTwoSided) : 0.0,
            0.5 * chi_square_quantile(2.0 * count + 2.0, kTwoSided)};
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
            std::max(0.0, sum - kTwoSided * deviation) / population.surveyed_m2,
            (sum + kTwoSided * deviation) / population.surveyed_m2};
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
