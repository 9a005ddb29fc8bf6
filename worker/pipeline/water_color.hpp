#pragma once

#include <cstdint>
#include <vector>

#include "schemas/reconstruction_options.hpp"
#include "worker/color/color_fit.hpp"
#include "worker/color/white_point.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::pipeline {

// What is known of the water's colour, and the surface without it.
struct WaterColor {
    color::ColorFit fit;               // with its `surface` only before it was stored
    std::int64_t num_lost_images = 0;  // of keyframes, that could not be read
    // These three are set if the water is known; the mesh takes the colours of the vertices.
    color::WhitePoint white = {};
    std::vector<types::Color> vertices = {};  // of the mesh, restored
    double limited_share = 0.0;  // of the sightings of vertices: RestoredColor::is_limited
};

// Returns whether colours without the water are asked for.
inline bool restores_color(const ReconstructionOptions& options) {
    return options.color == "restored";
}

}  // namespace divemesh::pipeline
