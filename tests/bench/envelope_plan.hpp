#pragma once

#include <string>
#include <vector>

#include "tests/bench/dive_change.hpp"

// The axes along which a dive gets harder, each by itself, and the steps on them.
namespace divemesh::bench {

struct EnvelopeStep {
    std::string label;                  // value with unit, or name
    std::vector<std::string> rendered;  // options of `simulate` beside those of the plain dive
    std::vector<std::string> options;   // of `reconstruct`: --set NAME=VALUE
    DiveChange change;
};

struct EnvelopeAxis {
    std::string name;
    bool ordered = true;  // each step is harder than the one before; else kinds side by side
    std::vector<EnvelopeStep> steps;
    std::string scene;  // of its own; "": those of the run
};

const std::vector<EnvelopeAxis>& envelope_axes();

// The size of the bench: scenes, seeds and the dives that it renders.
struct EnvelopeScale {
    std::vector<std::string> scenes;
    std::vector<int> seeds;
    double plain_length_m = 8.0;  // of the dives that steps alter
    double length_m = 4.0;        // of those that are rendered for a step
    bool sift = true;             // the baseline beside it
    int width_px = 320;
    int height_px = 240;
};

EnvelopeScale whole_envelope();  // two scenes, three seeds
EnvelopeScale quick_envelope();  // one scene, one seed, short dives

}  // namespace divemesh::bench
