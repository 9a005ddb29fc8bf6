#pragma once

#include <filesystem>

#include "worker/simulator/simulate.hpp"

namespace divemesh::bench {

// Renders a small dive over a barge with its truth: 1.5 m long, four pairs a second, clear water.
inline void render_small_dive(const std::filesystem::path& out) {
    simulator::simulate({.scene = simulator::SceneKind::Barge,
                         .out = out,
                         .length_m = 1.5,
                         .rate_hz = 4.0,
                         .seed = 3,
                         .water = simulator::WaterKind::Clear,
                         .truth = true,
                         .snow = false,
                         .fish = false,
                         .width_px = 240,
                         .height_px = 180});
}

}  // namespace divemesh::bench
