#include "worker/color/usable_sightings.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "worker/color/fit_problem.hpp"
#include "worker/stats/quantile.hpp"

namespace divemesh::color {
namespace {

constexpr std::size_t kMinSightings = 3;  // of a point: two leave no residual beside its colour
constexpr float kSaturated = 0.95F;       // linear light: level 249 of 255
constexpr float kSameLight = 1e-4F;       // of channels: rounding of their means
constexpr double kSpreadQuantile = 0.8;   // of the points: well seen
constexpr double kEndQuantile = 0.01;     // of the ranges, beyond which lie outliers

bool is_usable(const Sighting& sighting) {
    const bool is_light = std::all_of(sighting.rgb.begin(), sighting.rgb.end(), [](float light) {
        return light >= 0.0F && light < kSaturated;
    });
    return is_light && sighting.range_m > 0.0F && std::isfinite(sighting.range_m) &&
           std::isfinite(sighting.eccentricity) && sighting.cosine > 0.0F;
}

float largest(const Rgb& rgb) { return std::max({rgb[0], rgb[1], rgb[2]}); }

}  // namespace

Sightings usable_sightings(const Sightings& sightings) {
    Sightings kept{.num_keyframes = sightings.num_keyframes};
    for (std::size_t i = 0; i < sightings.all.size();) {
        const std::uint32_t point = sightings.all[i].point;
        const std::size_t before = kept.all.size();
        for (; i < sightings.all.size() && sightings.all[i].point == point; ++i) {
            if (!is_usable(sightings.all[i])) continue;
            kept.all.push_back(sightings.all[i]);
            kept.all.back().point = static_cast<std::uint32_t>(kept.num_points);
        }
        if (kept.all.size() - before >= kMinSightings)
            ++kept.num_points;
        else
            kept.all.resize(before);
    }
    return kept;
}

bool is_grey(const Sightings& sightings) {
    bool any_light = false;
    for (const Sighting& sighting : sightings.all) {
        const float most = largest(sighting.rgb);
        any_light = any_light || static_cast<double>(most) > kMinLight;
        if (most - std::min({sighting.rgb[0], sighting.rgb[1], sighting.rgb[2]}) >
            kSameLight * most)
            return false;
    }
    return any_light;
}

std::array<double, 3> lit_shares(const Sightings& sightings) {
    std::array<double, 3> shares = {};
    for (const Sighting& sighting : sightings.all)
        for (std::size_t c = 0; c < shares.size(); ++c)
            if (static_cast<double>(sighting.rgb[c]) > kMinLight) shares[c] += 1.0;
    for (double& share : shares) share /= std::max(1.0, static_cast<double>(sightings.all.size()));
    return shares;
}

Ranges ranges_of(const Sightings& sightings) {
    std::vector<double> all;
    all.reserve(sightings.all.size());
    std::vector<std::pair<double, double>> of_points(sightings.num_points, {1e9, 0.0});
    for (const Sighting& sighting : sightings.all) {
        const double range_m = static_cast<double>(sighting.range_m);
        all.push_back(range_m);
        auto& [nearest, farthest] = of_points[sighting.point];
        nearest = std::min(nearest, range_m);
        farthest = std::max(farthest, range_m);
    }
    std::vector<double> spreads;
    spreads.reserve(of_points.size());
    for (const auto& [nearest, farthest] : of_points) spreads.push_back(farthest - nearest);
    std::sort(all.begin(), all.end());
    return {stats::quantile_of_sorted(all, kEndQuantile),
            stats::quantile_of_sorted(all, 0.5),
            stats::quantile_of_sorted(all, 1.0 - kEndQuantile),
            stats::lower_quantile(spreads, kSpreadQuantile)};
}

}  // namespace divemesh::color
