#include "worker/stats/resample.hpp"

#include <algorithm>
#include <numeric>

#include "worker/stats/quantile.hpp"

namespace divemesh::stats {
namespace {

std::uint64_t next_random(std::uint64_t& state) {  // splitmix64 (Steele et al. 2014)
    state += 0x9e3779b97f4a7c15ULL;
    std::uint64_t z = state;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
}

}  // namespace

Estimate bootstrap(std::size_t num_individuals, const Statistic& statistic, std::uint64_t seed) {
    constexpr int kNumDraws = 1000;
    std::vector<std::size_t> drawn(num_individuals);
    std::iota(drawn.begin(), drawn.end(), std::size_t{0});
    const double value = statistic(drawn);
    std::vector<double> draws;
    std::uint64_t state = seed;
    for (int i = 0; i < kNumDraws; ++i) {
        for (std::size_t& individual : drawn) individual = next_random(state) % num_individuals;
        const double one = statistic(drawn);
        if (one == one) draws.push_back(one);
    }
    if (draws.empty()) return {value, value, value};
    std::sort(draws.begin(), draws.end());
    return {value, quantile_of_sorted(draws, 0.025), quantile_of_sorted(draws, 0.975)};
}

}  // namespace divemesh::stats
