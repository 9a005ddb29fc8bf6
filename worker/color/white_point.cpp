#include "worker/color/white_point.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "worker/stats/quantile.hpp"

namespace divemesh::color {
namespace {

constexpr double kPower = 6.0;       // with the smallest errors, as they found
constexpr double kMeanGrey = 0.5;    // linear light, of the mean with that power
constexpr double kBrightest = 0.99;  // quantile, beyond which a colour is an error

std::vector<double> channel_of(const std::vector<std::array<double, 3>>& surface,
                               std::size_t channel) {
    std::vector<double> values;
    values.reserve(surface.size());
    for (const auto& color : surface) values.push_back(color[channel]);
    std::sort(values.begin(), values.end());
    return values;
}

double median_of(const std::vector<std::array<double, 3>>& surface, std::size_t channel) {
    return std::max(1e-6, stats::quantile_of_sorted(channel_of(surface, channel), 0.5));
}

}  // namespace

WhitePoint white_point_of(const std::vector<std::array<double, 3>>& surface) {
    WhitePoint point;
    for (std::size_t c = 0; c < point.white.size(); ++c) {
        const std::vector<double> values = channel_of(surface, c);
        const double brightest = stats::quantile_of_sorted(values, kBrightest);
        double sum = 0.0;
        for (const double value : values) sum += std::pow(std::min(value, brightest), kPower);
        const double mean =
            std::pow(sum / std::max<double>(1.0, static_cast<double>(values.size())), 1.0 / kPower);
        point.white[c] = std::max(1e-6, mean / kMeanGrey);
        point.relative[c] = point.white[c] / median_of(surface, c);
    }
    return point;
}

WhitePoint white_point_like(const std::array<double, 3>& relative,
                            const std::vector<std::array<double, 3>>& surface) {
    WhitePoint point{.relative = relative};
    for (std::size_t c = 0; c < point.white.size(); ++c)
        point.white[c] = relative[c] * median_of(surface, c);
    return point;
}

}  // namespace divemesh::color
