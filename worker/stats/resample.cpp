#include "worker/stats/resample.hpp"

#include <algorithm>
#include <numeric>
#include <random>

#include "worker/stats/quantile.hpp"

namespace divemesh::stats {

Estimate bootstrap(std::size_t num_individuals, const Statistic& statistic, std::uint64_t seed) {
    constexpr int kNumDraws = 1000;
    std::vector<std::size_t> drawn(num_individuals);
    std::iota(drawn.begin(), drawn.end(), std::size_t{0});
    const double value = statistic(drawn);
    std::vector<double> draws;
    std::mt19937_64 random(seed);
    for (int i = 0; i < kNumDraws; ++i) {
        for (std::size_t& individual : drawn) individual = random() % num_individuals;
        const double one = statistic(drawn);
        if (one == one) draws.push_back(one);
    }
    if (draws.empty()) return {value, value, value};
    std::sort(draws.begin(), draws.end());
    return {value, quantile_of_sorted(draws, 0.025), quantile_of_sorted(draws, 0.975)};
}

}  // namespace divemesh::stats
