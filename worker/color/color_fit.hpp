#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

namespace divemesh::color {

// What lights the surface: the sky, lamps that travel with the camera, or both.
enum class LightSource : std::uint8_t { Ambient, Camera, Mixed };

// Whether the water is known, and why it is not.
enum class FitOutcome : std::uint8_t {
    Estimated,
    TooFewSightings,  // of one surface by several keyframes
    // The sightings are from about as far, or do not tell the water from the colours of the
    // surface, though there is light enough in all channels.
    TooLittleRange,
    NothingToRestore,  // the colours do not change with the range: air, or very clear water
    NotExplained,      // they change, but not as water changes them
    Grey,              // the images have no colours
    // At least one channel has too little light to tell its water, as red has at depth. The others
    // may be known (ChannelFit::known), but two channels do not restore a colour.
    ChannelTooDark,
    NotConverged,  // no minimum, or one at a bound of what water can be
};

std::string_view to_string(LightSource light);
std::string_view to_string(FitOutcome outcome);

// An estimated value with its standard deviation.
struct Value {
    double value = 0.0;
    double sigma = 0.0;

    bool operator==(const Value&) const = default;
};

// How the water changes one channel (Akkaynak and Treibitz, "A revised underwater image formation
// model", 2018): a surface of colour J at range r is seen as
//     I = J D + veil (1 - exp(-backscatter r)).
// D = t = exp(-attenuation r) for light from the sky, D = L for lamps that travel with the camera,
// and D = t + lamp L for both, with L = cosine exp(-attenuation (r + l)) / l^2 and
// l = sqrt(r^2 + kLampOffset_m^2): light falls off with its way to the surface (Lambert).
struct ChannelFit {
    Value attenuation_per_m;
    Value backscatter_per_m;
    Value veil;  // linear light of water without end; 1 is the white of the images
    Value lamp;  // light of the lamps on surface at 1 m, relative to that of the sky
    // The share that the water explains of the variance that the logarithm of one surface's colours
    // has with the same light in air. Both are after the gains of the keyframes and the
    // vignetting.
    double explained_share = 0.0;
    double noise = 0.0;  // of dark pixels, linear light, standard deviation
    // Standard deviation of backscatter() at the far end of the ranges.
    double far_backscatter_sigma = 0.0;
    // Whether the sightings tell the water of this channel; else its values say little more than
    // the priors, and their sigmas may be infinite.
    bool known = false;

    bool operator==(const ChannelFit&) const = default;
};
// Returns a coefficient in 1/m with what it is not known by: its own standard deviation, which is
// of noise alone, and the errors of the model. Lamps, caustics and shading are not quite as
// modelled, and over a few metres they look like water.
Value with_model_error(const Value& coefficient_per_m);
// How far lamps are from the axis of the camera: on arms of half a metre.
inline constexpr double kLampOffset_m = 0.5;

// The shares of the light from a surface that arrive, by the way of the light that is on it.
struct DirectShare {
    double sky = 0.0;    // t
    double lamps = 0.0;  // L for a cosine of 1
};
// Returns the way from lamps to a surface.
double way_from_lamps_m(double range_m);
// Returns both shares for light of strength 1.
DirectShare direct_share(double attenuation_per_m, double range_m);
// Returns the shares of the sky's and the lamps' light that arrive; D = sky + cosine * lamps.
DirectShare direct_share(const ChannelFit& channel, LightSource light, double range_m);
// Returns the light that the water itself adds over a range.
double backscatter(const ChannelFit& channel, double range_m);

// The colour of the water of a dive.
struct ColorFit {
    FitOutcome outcome = FitOutcome::TooFewSightings;
    LightSource light = LightSource::Ambient;
    bool is_fitted = false;              // whether the sightings allowed a fit, good or bad
    std::array<ChannelFit, 3> channels;  // r g b
    double explained_share = 0.0;        // mean over the known channels
    double vignetting = 0.0;             // share of light that is lost in the farthest corner
    double near_m = 0.0;                 // the ranges that the fit rests on
    double far_m = 0.0;
    std::int64_t num_points = 0;
    std::int64_t num_sightings = 0;
    std::vector<double> log_gains;               // one per keyframe, mean about 0
    std::vector<std::array<double, 3>> surface;  // colours J of the points

    bool is_known() const { return outcome == FitOutcome::Estimated; }
};

}  // namespace divemesh::color
