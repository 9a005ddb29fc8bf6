#include "worker/reef/population.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace divemesh::worker {
namespace {

constexpr double kTwoSided = 1.959964;

double chi_square_quantile(double degrees_of_freedom, double z) {
    const double part = 2.0 / (9.0 * degrees_of_freedom);
    return degrees_of_freedom * std::pow(1.0 - part + z * std::sqrt(part), 3.0);
}

double quantile_of_sorted(const std::vector<double>& sorted, double share) {
    const double place = share * static_cast<double>(sorted.size() - 1);
    const auto below = static_cast<std::size_t>(place);
    const std::size_t above = std::min(below + 1, sorted.size() - 1);
    return sorted[below] + (place - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

std::uint64_t next_random(std::uint64_t& state) {  // splitmix64 (Steele et al. 2014)
    state += 0x9e3779b97f4a7c15ULL;
    std::uint64_t z = state;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
}

}  // namespace

Estimate density_per_m2(const Population& population) {
    const auto count = static_cast<double>(population.areas_m2.size());
    const double low = count > 0.0 ? 0.5 * chi_square_quantile(2.0 * count, -kTwoSided) : 0.0;
    const double high = 0.5 * chi_square_quantile(2.0 * count + 2.0, kTwoSided);
    return {count / population.surveyed_m2,
            low / population.surveyed_m2,
            high / population.surveyed_m2};
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

Estimate size_quantile(std::vector<double> sizes, double share, std::uint64_t seed) {
    std::sort(sizes.begin(), sizes.end());
    constexpr int kNumDraws = 1000;
    std::vector<double> draws;
    std::uint64_t state = seed;
    for (int i = 0; i < kNumDraws; ++i) {
        std::vector<double> drawn;
        for (std::size_t k = 0; k < sizes.size(); ++k)
            drawn.push_back(sizes[next_random(state) % sizes.size()]);
        std::sort(drawn.begin(), drawn.end());
        draws.push_back(quantile_of_sorted(drawn, share));
    }
    std::sort(draws.begin(), draws.end());
    return {quantile_of_sorted(sizes, share),
            quantile_of_sorted(draws, 0.025),
            quantile_of_sorted(draws, 0.975)};
}

}  // namespace divemesh::worker
