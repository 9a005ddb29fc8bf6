#pragma once

#include "worker/simulator/diver_motion.hpp"
#include "worker/simulator/simulate.hpp"
#include "worker/simulator/water.hpp"

namespace divemesh::simulator {

// How one dive differs from another of the same place: nobody swims the same way twice, and no two
// days have the same water.
struct Survey {
    std::uint64_t seed = 0;  // of motion, sensors' noise, fish and snow
    SurveyPath path;
    Water water;
};

// The first survey of the first year swims the scene's own path in the water as named, with the
// seed of the place. Every other one begins elsewhere, up to 0.3 m aside and 0.25 m higher, looks
// up to 4 degrees aside and sees 15 % less far to 15 % farther.
Survey plan_survey(const SimulateOptions& options, const SurveyPath& of_scene, WaterKind water);

}  // namespace divemesh::simulator
