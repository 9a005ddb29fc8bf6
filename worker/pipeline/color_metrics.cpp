#include "worker/pipeline/color_metrics.hpp"

#include <string>

#include "worker/base/text.hpp"

namespace divemesh::pipeline {
namespace {

using nlohmann::json;

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

Cause cause_of(const color::ColorFit& fit) {
    switch (fit.outcome) {
        case color::FitOutcome::Estimated: break;
        case color::FitOutcome::TooFewSightings:
            return {"only " + std::to_string(fit.num_points) +
                        " of the sampled points of the surface are seen by three keyframes or more",
                    "swim over the place again so that the images overlap more"};
        case color::FitOutcome::TooLittleRange:
            return {"the same surface is always seen from about as far (the images reach from " +
                        base::fixed(fit.near_m, 1) + " to " + base::fixed(fit.far_m, 1) +
                        " m), so that the effect of the water cannot be told from the colours",
                    "on the next dive look at some of the place from near and from far"};
        case color::FitOutcome::NothingToRestore:
            return {"the colours of the surface do not change with the range from " +
                        base::fixed(fit.near_m, 1) + " to " + base::fixed(fit.far_m, 1) +
                        " m: it was recorded in air, or in water too clear to matter",
                    "nothing needs to be done: raw colours are right here"};
        case color::FitOutcome::NotExplained:
            return {"water explains only " + base::fixed(100.0 * fit.explained_share, 0) +
                        " % of how the colours of the surface vary between keyframes, or would "
                        "have to add light with the range",
                    "record with even light: caustics, moving lamps and automatic white balance "
                    "change colours more than this water does"};
        case color::FitOutcome::Grey:
            return {"the images have no colours, their three channels are equal",
                    "record in colour"};
        case color::FitOutcome::ChannelTooDark:
            return {"no light is left in " + dark_channels(fit) +
                        ", and what no image shows cannot be restored",
                    "bring lamps, or go nearer: red light is lost within a few metres of water"};
        case color::FitOutcome::NotConverged:
            return {"no water explains how the colours change from " + base::fixed(fit.near_m, 1) +
                        " to " + base::fixed(fit.far_m, 1) + " m: the fit found no minimum",
                    "record with one kind of light throughout, all lamps on or all off"};
    }
    return {};
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
    // Nothing was fitted where no point or no range allowed it.
    if (fit.channels[0].noise > 0.0) {
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
    if (color.fit.is_known()) return std::nullopt;
    const Cause cause = cause_of(color.fit);
    return Finding{Severity::Warning,
                   "color_not_restored",
                   "",
                   "the colours stay as recorded, though color=restored: " + cause.message,
                   cause.remedy};
}

}  // namespace divemesh::pipeline
