#pragma once

#include "worker/simulator/diver_motion.hpp"
#include "worker/simulator/simulate.hpp"
#include "worker/simulator/water.hpp"

namespace divemesh::simulator {

// The differences between one dive and another of the same place: a path is never swum the same way
// twice, and the water is different every day.
struct Survey {
    std::uint64_t seed = 0;  // of motion, sensor noise, fish and snow
    SurveyPath path;
    Water water;
};

// Returns the plan of a survey. The first survey of the first year uses the scene's own path, the
// water as named and the seed of the place. Every other one begins elsewhere, up to 0.3 m to the
// side and 0.25 m higher, looks up to 4 degrees to the side, and has a visibility that is up to 15
// % shorter or longer. Speed, sway, light and turbidity of the options apply to all.
Survey plan_survey(const SimulateOptions& options, const SurveyPath& of_scene, WaterKind water);

}  // namespace divemesh::simulator
