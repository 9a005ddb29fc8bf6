#include "worker/color/water_unknowns.hpp"

#include <algorithm>
#include <cmath>

namespace divemesh::color {
namespace {

// The shares of two sources in what lights a surface.
struct Lighting {
    double sky = 1.0;
    double lamps = 0.0;
};

Lighting lighting(const FitModel& model, double lamp) {
    switch (model.light) {
        case LightSource::Ambient: return {1.0, 0.0};
        case LightSource::Camera: return {0.0, 1.0};
        case LightSource::Mixed: return {1.0, lamp};
    }
    return {};
}

}  // namespace

WaterUnknowns::GainPlace WaterUnknowns::gain_place(std::size_t keyframe,
                                                   std::size_t num_keyframes) const {
    if (log_gains.size() < 2 || num_keyframes < 2) return {};
    const std::size_t steps = num_keyframes - 1;
    const std::size_t place = keyframe * (log_gains.size() - 1);
    return {place / steps, static_cast<double>(place % steps) / static_cast<double>(steps)};
}

double WaterUnknowns::log_gain(std::size_t keyframe, std::size_t num_keyframes) const {
    const GainPlace place = gain_place(keyframe, num_keyframes);
    const double before = log_gains[place.knot];
    if (place.share <= 0.0) return before;
    return before + place.share * (log_gains[place.knot + 1] - before);
}

Prediction predict(const FitModel& model,
                   const ChannelUnknowns& water,
                   double gain,
                   double vignetting,
                   const Sighting& sighting,
                   double color) {
    const double r = static_cast<double>(sighting.range_m);
    const double eccentricity = static_cast<double>(sighting.eccentricity);
    const double response = gain * (1.0 - vignetting * eccentricity);
    const double attenuation_per_m = model.has_water ? water.attenuation_per_m : 0.0;
    const DirectShare share = model.light == LightSource::Ambient
                                  ? DirectShare{std::exp(-attenuation_per_m * r), 0.0}
                                  : direct_share(attenuation_per_m, r);
    const double lamp = static_cast<double>(sighting.cosine) * share.lamps;
    const Lighting by = lighting(model, water.lamp);
    const double direct = by.sky * share.sky + by.lamps * lamp;
    const double through = model.has_water ? std::exp(-water.backscatter_per_m * r) : 1.0;
    const double light = color * direct + water.veil * (1.0 - through);
    const double lamp_way_m = r + way_from_lamps_m(r);
    return {
        .value = response * light,
        .by_color = response * direct,
        .by_channel = {-response * color * (r * by.sky * share.sky + lamp_way_m * by.lamps * lamp),
                       response * water.veil * r * through,
                       response * (1.0 - through),
                       response * color * lamp},
        .by_vignetting = -gain * eccentricity * light};
}

void clamp(WaterUnknowns& unknowns) {
    for (ChannelUnknowns& channel : unknowns.channels)
        for (std::size_t i = 0; i < ChannelUnknowns::kSize; ++i)
            channel[i] = std::clamp(channel[i], kChannelBounds[i].min, kChannelBounds[i].max);
    unknowns.vignetting =
        std::clamp(unknowns.vignetting, kVignettingBounds.min, kVignettingBounds.max);
}

}  // namespace divemesh::color
