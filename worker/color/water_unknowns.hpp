#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "worker/color/color_fit.hpp"
#include "worker/color/sighting.hpp"

namespace divemesh::color {

// The unknowns of a channel, in the order of its columns.
struct ChannelUnknowns {
    double attenuation_per_m = 0.0;
    double backscatter_per_m = 0.0;
    double veil = 0.0;
    double lamp = 0.0;

    static constexpr int kSize = 4;

    double& operator[](std::size_t i) {
        return *std::array{&attenuation_per_m, &backscatter_per_m, &veil, &lamp}[i];
    }
    double operator[](std::size_t i) const {
        return std::array{attenuation_per_m, backscatter_per_m, veil, lamp}[i];
    }
};

// The unknowns besides the colour of each point.
struct WaterUnknowns {
    std::array<ChannelUnknowns, 3> channels;
    double vignetting = 0.0;
    std::vector<double> log_gains;  // at knots, evenly spread over the keyframes; linear between

    // A keyframe between two knots: `share` of the way from `knot` to the next.
    struct GainPlace {
        std::size_t knot = 0;
        double share = 0.0;
    };
    GainPlace gain_place(std::size_t keyframe, std::size_t num_keyframes) const;
    double log_gain(std::size_t keyframe, std::size_t num_keyframes) const;
};

// The values that an unknown may have.
struct Bounds {
    double min = 0.0;
    double max = 0.0;
};
// Bounds of ChannelUnknowns, in order; chosen wide. Attenuation may be below 0, so that noise about
// 0 has no bias; the others may not.
inline constexpr std::array<Bounds, ChannelUnknowns::kSize> kChannelBounds = {
    {{-0.3, 6.0}, {0.005, 8.0}, {0.0, 2.0}, {0.0, 50.0}}};
// Chosen wide; below 0 for cameras that correct too much of it.
inline constexpr Bounds kVignettingBounds = {-0.3, 0.9};

// A model. Without water the light is the same, but loses nothing on its way and has no
// backscatter: the colours change with it, gains and vignetting alone.
struct FitModel {
    bool has_water = true;
    LightSource light = LightSource::Ambient;

    // Returns whether unknown i of ChannelUnknowns is one of this model.
    bool has(std::size_t i) const {
        const bool is_lamp = i + 1 == ChannelUnknowns::kSize;
        return is_lamp ? light == LightSource::Mixed : has_water;
    }
};

// The light of a sighting by the model, and its derivatives.
struct Prediction {
    double value = 0.0;
    double by_color = 0.0;
    std::array<double, ChannelUnknowns::kSize> by_channel = {};
    double by_vignetting = 0.0;  // that by the logarithm of the gain is `value`
};

// Returns the light of a surface of colour `color` in a channel, as ChannelFit states it, times the
// gain of its keyframe and what vignetting leaves.
Prediction predict(const FitModel& model,
                   const ChannelUnknowns& water,
                   double gain,
                   double vignetting,
                   const Sighting& sighting,
                   double color);

// Moves the unknowns into their bounds.
void clamp(WaterUnknowns& unknowns);

}  // namespace divemesh::color
