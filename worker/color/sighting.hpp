#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "worker/color/linear_light.hpp"

namespace divemesh::color {

// One point of the surface as one keyframe shows it.
struct Sighting {
    std::uint32_t point = 0;
    std::uint32_t keyframe = 0;
    float range_m = 0.0F;  // from the camera
    // The squared distance from the principal point, 1 in the farthest corner.
    float eccentricity = 0.0F;
    float cosine = 1.0F;  // of the angle between the normal and the direction to the camera
    Rgb rgb = {};         // linear light, mean over a few pixels
};

// Points of the surface, each seen by several keyframes.
struct Sightings {
    std::size_t num_points = 0;
    std::size_t num_keyframes = 0;
    std::vector<Sighting> all = {};   // by point, then by keyframe
    std::size_t num_lost_images = 0;  // of keyframes, that could not be read
};

}  // namespace divemesh::color
