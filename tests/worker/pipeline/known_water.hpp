#pragma once

#include "worker/pipeline/water_color.hpp"

namespace divemesh::pipeline {

inline constexpr color::LightSource kLightSources[] = {
    color::LightSource::Ambient, color::LightSource::Camera, color::LightSource::Mixed};
inline constexpr color::FitOutcome kFailedOutcomes[] = {color::FitOutcome::TooFewSightings,
                                                        color::FitOutcome::TooLittleRange,
                                                        color::FitOutcome::NothingToRestore,
                                                        color::FitOutcome::NotExplained,
                                                        color::FitOutcome::Grey,
                                                        color::FitOutcome::ChannelTooDark,
                                                        color::FitOutcome::NotConverged};

// Returns water that is known, with everything set and no two numbers alike.
inline WaterColor known_water(color::LightSource light = color::LightSource::Mixed) {
    WaterColor water;
    water.fit.outcome = color::FitOutcome::Estimated;
    water.fit.light = light;
    water.fit.is_fitted = true;
    water.fit.channels = {
        color::ChannelFit{
            {0.55, 0.011}, {0.41, 0.021}, {0.03, 0.001}, {0.8, 0.12}, 0.9, 0.0011, 0.0041},
        color::ChannelFit{
            {0.27, 0.012}, {0.26, 0.022}, {0.19, 0.002}, {0.6, 0.13}, 0.7, 0.0012, 0.0042},
        color::ChannelFit{
            {0.32, 0.013}, {0.29, 0.023}, {0.18, 0.003}, {0.7, 0.14}, 0.5, 0.0013, 0.0043}};
    for (color::ChannelFit& channel : water.fit.channels) channel.known = true;
    water.num_lost_images = 3;
    water.fit.explained_share = 0.71;
    water.fit.vignetting = 0.21;
    water.fit.near_m = 0.84;
    water.fit.far_m = 4.53;
    water.fit.num_points = 5120;
    water.fit.num_sightings = 40960;
    water.fit.log_gains = {0.1, -0.15, 0.05};
    water.fit.surface = {{0.4, 0.35, 0.25}};
    water.white = {{0.95, 1.05, 1.15}, {1.9, 2.1, 2.4}};
    water.vertices = {{10, 20, 30}, {200, 100, 50}};
    water.limited_share = 0.125;
    return water;
}

}  // namespace divemesh::pipeline
