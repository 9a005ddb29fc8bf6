#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "worker/color/color_fit.hpp"
#include "worker/color/sighting.hpp"

namespace divemesh::color {

// What the colours of a synthetic dive are drawn from.
struct WaterWorld {
    std::array<ChannelFit, 3> channels;
    LightSource light = LightSource::Ambient;
    double vignetting = 0.2;
    double gain_sigma = 0.1;      // of the logarithm, per keyframe
    double gain_wave = 0.0;       // amplitude of the logarithm, over all keyframes
    double noise = 0.03;          // share of the light
    double dark_noise = 0.0005;   // linear light
    double outlier_share = 0.05;  // fish
    double near_m = 0.8;
    double far_m = 4.0;
    std::size_t num_points = 1500;
    std::size_t num_keyframes = 40;
    std::size_t num_sightings = 10;  // of a point
};

// Returns D of ChannelFit.
inline double direct_of(const ChannelFit& channel, LightSource light, double r, double cosine) {
    const DirectShare share = direct_share(channel, light, r);
    return share.sky + cosine * share.lamps;
}

inline ChannelFit channel_of(double attenuation, double backscatter, double veil, double lamp = 0) {
    return {{attenuation, 0.0}, {backscatter, 0.0}, {veil, 0.0}, {lamp, 0.0}, 0.0, 0.001};
}

// Green water, as published for coastal water of Jerlov's type 3 or so.
inline std::array<ChannelFit, 3> green_water(double lamp = 0.0) {
    return {channel_of(0.55, 0.40, 0.03, lamp),
            channel_of(0.27, 0.26, 0.20, 0.7 * lamp),
            channel_of(0.32, 0.29, 0.18, 0.8 * lamp)};
}

// The slow part of the logarithm of a keyframe's gain.
inline double log_wave(const WaterWorld& world, std::size_t keyframe) {
    return world.gain_wave * std::sin(20.0 * static_cast<double>(keyframe) /
                                      static_cast<double>(world.num_keyframes));
}

// Draws sightings from the model itself, with noise and outliers. Each point is seen from a range
// of its own on, as an approaching camera sees it.
inline Sightings draw_sightings(const WaterWorld& world, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform;
    std::vector<double> gains(world.num_keyframes);
    for (std::size_t k = 0; k < gains.size(); ++k)
        gains[k] = std::exp(world.gain_sigma * normal(random) + log_wave(world, k));
    Sightings sightings{world.num_points, world.num_keyframes, {}};
    for (std::size_t point = 0; point < world.num_points; ++point) {
        const double brightness = 0.05 + 0.6 * uniform(random);
        const std::array<double, 3> color = {brightness * (0.7 + 0.3 * uniform(random)),
                                             brightness * (0.6 + 0.3 * uniform(random)),
                                             brightness * (0.4 + 0.4 * uniform(random))};
        const auto first = static_cast<std::size_t>(
            uniform(random) * static_cast<double>(world.num_keyframes - world.num_sightings));
        for (std::size_t k = first; k < first + world.num_sightings; ++k) {
            const double r = world.near_m + (world.far_m - world.near_m) * uniform(random);
            const double eccentricity = uniform(random);
            const double cosine = 0.4 + 0.6 * uniform(random);
            const double response = gains[k] * (1.0 - world.vignetting * eccentricity);
            Sighting sighting{static_cast<std::uint32_t>(point),
                              static_cast<std::uint32_t>(k),
                              static_cast<float>(r),
                              static_cast<float>(eccentricity),
                              static_cast<float>(cosine),
                              {}};
            const bool is_fish = uniform(random) < world.outlier_share;
            for (std::size_t c = 0; c < 3; ++c) {
                const ChannelFit& channel = world.channels[c];
                const double light =
                    response * (color[c] * direct_of(channel, world.light, r, cosine) +
                                backscatter(channel, r));
                const double seen = is_fish ? 0.3 * uniform(random)
                                            : light * (1.0 + world.noise * normal(random)) +
                                                  world.dark_noise * normal(random);
                sighting.rgb[c] = static_cast<float>(std::max(0.0, seen));
            }
            sightings.all.push_back(sighting);
        }
    }
    return sightings;
}

}  // namespace divemesh::color
