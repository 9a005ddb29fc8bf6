#include "worker/color/color_fit.hpp"

#include <cmath>

#include "schemas/enum_text.hpp"

namespace divemesh::color {
namespace {

constexpr EnumText<LightSource> kLights[] = {{LightSource::Ambient, "ambient"},
                                             {LightSource::Camera, "camera"},
                                             {LightSource::Mixed, "mixed"}};
constexpr EnumText<FitOutcome> kOutcomes[] = {{FitOutcome::Estimated, "estimated"},
                                              {FitOutcome::TooFewSightings, "too_few_sightings"},
                                              {FitOutcome::TooLittleRange, "too_little_range"},
                                              {FitOutcome::NothingToRestore, "nothing_to_restore"},
                                              {FitOutcome::NotExplained, "not_explained"},
                                              {FitOutcome::Grey, "grey"},
                                              {FitOutcome::ChannelTooDark, "channel_too_dark"},
                                              {FitOutcome::NotConverged, "not_converged"}};

}  // namespace

std::string_view to_string(LightSource light) { return enum_to_text(kLights, light); }

std::string_view to_string(FitOutcome outcome) { return enum_to_text(kOutcomes, outcome); }

Value with_model_error(const Value& coefficient_per_m) {
    // One standard deviation of the errors over simulated dives of two places in three waters
    // (tests/bench/run.sh --only color): a part by itself, and one that grows with the coefficient.
    constexpr double kOffset_per_m = 0.05;
    constexpr double kShare = 0.2;
    const double value = coefficient_per_m.value;
    return {value, std::hypot(coefficient_per_m.sigma, kOffset_per_m + kShare * std::abs(value))};
}

double way_from_lamps_m(double range_m) {
    return std::sqrt(range_m * range_m + kLampOffset_m * kLampOffset_m);  // hypot takes far longer
}

DirectShare direct_share(double attenuation_per_m, double range_m) {
    const double through = std::exp(-attenuation_per_m * range_m);
    const double from_lamp_m = way_from_lamps_m(range_m);
    return {through,
            through * std::exp(-attenuation_per_m * from_lamp_m) / (from_lamp_m * from_lamp_m)};
}

DirectShare direct_share(const ChannelFit& channel, LightSource light, double range_m) {
    const DirectShare share = direct_share(channel.attenuation_per_m.value, range_m);
    switch (light) {
        case LightSource::Ambient: return {share.sky, 0.0};
        case LightSource::Camera: return {0.0, share.lamps};
        case LightSource::Mixed: return {share.sky, channel.lamp.value * share.lamps};
    }
    return {};
}

double backscatter(const ChannelFit& channel, double range_m) {
    return channel.veil.value * -std::expm1(-channel.backscatter_per_m.value * range_m);
}

}  // namespace divemesh::color
