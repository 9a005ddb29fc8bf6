#pragma once

#include <cstdint>
#include <optional>

#include "worker/video/sound_envelope.hpp"

namespace divemesh::video {

// How the clocks of two videos differ: time on the left clock = right stamp + offset + drift times
// right stamp.
struct ClockOffset {
    double offset_s = 0.0;
    double drift = 0.0;    // seconds a second
    double sigma_s = 0.0;  // one standard deviation of the offset

    std::int64_t left_ns(std::int64_t right_ns) const;
};

// Finds how two videos differ by what both cameras heard; nullopt if that is not clear. Cameras in
// a dive hear each other's housings, bubbles and the water: what they share is found by a
// correlation without its colour (phase transform, Knapp and Carter 1976), and windows over the
// whole sound have to agree. Clocks that are heard for two minutes show their drift too.
std::optional<ClockOffset> offset_by_sound(const SoundEnvelope& left, const SoundEnvelope& right);

}  // namespace divemesh::video
