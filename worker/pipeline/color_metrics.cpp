#include "worker/pipeline/color_metrics.hpp"

#include <string>

#include "worker/base/text.hpp"

namespace divemesh::pipeline {
namespace {

using nlohmann::json;

constexpr double kMaxLimitedShare = 0.15;

json estimate(const color::Value& of) { return {{"value", of.value}, {"sigma", of.sigma}}; }

json channel_json(const color::ChannelFit& channel, color::LightSource light) {
    json result = {
        {"attenuation_per_m", estimate(color::with_model_error(channel.attenuation_per_m))},
        {"backscatter_per_m", estimate(color::with_model_error(channel.backscatter_per_m))},
        {"veil", estimate(channel.veil)},
        {"explained_share", channel.explained_share}};
    if (light == color::LightSource::Mixed) result["lamp"] = estimate(channel.lamp);
    return result;
}

constexpr const char* kChannels[] = {"red", "green", "blue"};

std::string dark_channels(const color::ColorFit& fit) {
    std::string names;
    for (std::size_t c = 0; c < fit.channels.size(); ++c)
        if (!fit.channels[c].known)
            names += (names.empty() ? "" : " and ") + std::string(kChannels[c]);
    return names;
}

// Why the water is not known, and what to do.
struct Cause {
    std::string message;
    std::string remedy;
};

Cause too_few_sightings(const WaterColor& color) {
    const std::string message =
        "only " + std::to_string(color.fit.num_points) +
        " of the sampled points of the surface are seen by three keyframes or more without "
        "clipping";
    if (color.num_lost_images == 0)
        return {message, "swim over the place again so that the images overlap more"};
    return {message + "; the images of " + std::to_string(color.num_lost_images) +
                " keyframes could not be read",
            "check the disks and reconstruct again"};
}

Cause cause_of(const WaterColor& color) {
    const color::ColorFit& fit = color.fit;
    switch (fit.outcome) {
        case color::FitOutcome::Estimated: break;
        case color::FitOutcome::TooFewSightings: return too_few_sightings(color);
        case color::FitOutcome::TooLittleRange:
            return {"the images from " + base::fixed(fit.near_m, 1) + " to " +
                        base::fixed(fit.far_m, 1) +
                        " m do not tell the effect of the water from the colours of the surface",
                    "on the next dive look at some of the place from near and from far"};
        case color::FitOutcome::NothingToRestore:
            return {"the colours of the surface do not change with the range from " +
                        base::fixed(fit.near_m, 1) + " to " + base::fixed(fit.far_m, 1) +
                        " m: it was recorded in air, or in water too clear to matter",
                    "nothing needs to be done: raw colours are right here"};
        case color::FitOutcome::NotExplained:
            return {
                "the colours change with the range, but not as water changes them: it explains " +
                    base::fixed(100.0 * fit.explained_share, 0) +
                    " % of how they vary between keyframes, or would have to add light",
                "record with even light: caustics, moving lamps and automatic white balance "
                "change colours more than this water does"};
        case color::FitOutcome::Grey:
            return {"the images have no colours, their three channels are equal",
                    "record in colour"};
        case color::FitOutcome::ChannelTooDark:
            return {"too little light is left in " + dark_channels(fit) +
                        " to tell what the water takes of it",
                    "bring lamps, or go nearer: red light is lost within a few metres of water"};
        case color::FitOutcome::NotConverged:
            return {"no water explains how the colours change from " + base::fixed(fit.near_m, 1) +
                        " to " + base::fixed(fit.far_m, 1) + " m: the fit found no minimum",
                    "record with one kind of light throughout, all lamps on or all off"};
    }
    return {};
}

// Returns a warning where the water left too little of the light for much of the surface.
std::optional<Finding> limited_finding(const WaterColor& color) {
    if (color.limited_share <= kMaxLimitedShare) return std::nullopt;
    return Finding{Severity::Warning,
                   "color_partly_restored",
                   "",
                   "too little light came from " + base::fixed(100.0 * color.limited_share, 0) +
                       " % of what the keyframes see of the surface: there the colours are only "
                       "restored in part",
                   "do not compare colours of the far parts; go nearer, or bring more light"};
}

}  // namespace

json to_metrics(const WaterColor& color) {
    const color::ColorFit& fit = color.fit;
    json result = {{"outcome", to_string(fit.outcome)},
                   {"restored", fit.is_known()},
                   {"num_points", fit.num_points},
                   {"num_sightings", fit.num_sightings},
                   {"num_lost_images", color.num_lost_images},
                   {"near_m", fit.near_m},
                   {"far_m", fit.far_m}};
    if (fit.is_fitted) {
        result["light"] = to_string(fit.light);
        result["explained_share"] = fit.explained_share;
        result["vignetting"] = fit.vignetting;
        for (std::size_t c = 0; c < fit.channels.size(); ++c)
            if (fit.channels[c].known)
                result[kChannels[c]] = channel_json(fit.channels[c], fit.light);
    }
    if (!fit.is_known()) return result;
    result["white_point"] = color.white.relative;
    result["limited_share"] = color.limited_share;
    return result;
}

std::optional<Finding> color_finding(const WaterColor& color) {
    if (color.fit.is_known()) return limited_finding(color);
    const Cause cause = cause_of(color);
    return Finding{Severity::Warning,
                   "color_not_restored",
                   "",
                   "the colours stay as recorded, though color=restored: " + cause.message,
                   cause.remedy};
}

}  // namespace divemesh::pipeline
