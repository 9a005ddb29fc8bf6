#pragma once

#include <cstdint>
#include <vector>

#include "worker/simulator/diver_motion.hpp"
#include "worker/simulator/lay_markers.hpp"
#include "worker/types/geographic_position.hpp"
#include "worker/types/outside_positions.hpp"

namespace divemesh::simulator {

// Returns where the origin of a simulated world lies on the earth, and the azimuth of its x axis.
types::GeographicPosition place_on_earth(std::uint64_t seed);

// Returns positions of the rig in UTM. USBL: one in 2 s, 0.3 m of white noise, one in ten off by 5
// to 40 m. GPS of a float: one a second, an offset of about 2 m for the whole dive, 1.5 m that
// change within a minute, one in forty off by 5 to 40 m, no height. A fix at the surface: one, at
// the start.
types::PositionSource simulate_positions(const DiverMotion& motion,
                                         double duration_s,
                                         types::PositionKind kind,
                                         bool noise,
                                         std::uint64_t seed);

// Sets velocities over ground at 5 Hz in the axes of an instrument that looks down and is rotated
// by 45 degrees: 1 cm/s of white noise and a scale that is off by about 0.3 %.
void simulate_velocities(const DiverMotion& motion,
                         double duration_s,
                         bool noise,
                         std::uint64_t seed,
                         types::OutsidePositions& outside);

// Sets the positions of the markers, with 2 cm of noise.
void survey_markers(const std::vector<LaidMarker>& markers,
                    bool noise,
                    std::uint64_t seed,
                    types::OutsidePositions& outside);

}  // namespace divemesh::simulator
