#pragma once

#include <array>

#include "worker/color/color_fit.hpp"

namespace divemesh::color {

// What besides the fit itself decides whether it may be used.
struct FitEvidence {
    bool has_converged = false;            // with vignetting within its bounds
    std::array<bool, 3> is_at_bound = {};  // an unknown of the channel, at the largest it may be
    std::array<double, 3> lit_share = {};  // of the sightings
    std::array<double, 3> median_color = {};
};

// Sets what of the water is known, the mean of the explained shares, and the outcome.
void judge_fit(const FitEvidence& evidence, ColorFit& fit);

}  // namespace divemesh::color
