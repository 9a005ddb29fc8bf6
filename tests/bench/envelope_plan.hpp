#pragma once

#include <string>
#include <vector>

#include "tests/bench/dive_change.hpp"

// The axes of the envelope: along each one a dive gets harder, step by step.
namespace divemesh::bench {

struct EnvelopeStep {
    std::string label;                  // value with unit, or name
    std::vector<std::string> rendered;  // options of `simulate`, added to those of the plain dive
    std::vector<std::string> options;   // NAME=VALUE of `reconstruct --set`
    DiveChange change;
    double length_m = 0.0;  // of the dive rendered for it; 0: that of the scale
};

struct EnvelopeAxis {
    std::string name;
    bool ordered = true;  // each step is harder than the one before; false: the steps are kinds
    std::vector<EnvelopeStep> steps;
    std::string scene;  // "": the scenes of the run
};

const std::vector<EnvelopeAxis>& envelope_axes();

// The size of the bench: scenes, seeds and rendered dives.
struct EnvelopeScale {
    std::vector<std::string> scenes;
    std::vector<int> seeds;
    double plain_length_m = 8.0;  // of the plain dives that steps alter
    double length_m = 4.0;        // of the dives that are rendered for one step
    bool sift = true;             // also runs the baseline with SIFT
    int width_px = 320;
    int height_px = 240;
};

EnvelopeScale whole_envelope();  // two scenes, three seeds
EnvelopeScale quick_envelope();  // one scene, one seed, short dives

}  // namespace divemesh::bench
