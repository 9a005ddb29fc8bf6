#pragma once

#include <optional>
#include <vector>

#include "worker/dive/epipolar_samples.hpp"

namespace divemesh::dive {

// How much later the right images were exposed than the left ones of their pairs, by the images
// alone: a feature that moves across the epipolar lines leaves its line by its rate times the
// delay.
struct StereoDelay {
    double delay_s = 0.0;
    double sigma_s = 0.0;  // one standard deviation, from the scatter between moments
    // The share of the corners that are found in the right image, as predicted: the larger of two,
    // by the motion of the corners, and by the pairs alone, as slow cameras do not show corners
    // again. nullopt: too few corners to tell.
    std::optional<double> share_fitting;
    double spread_px = 0.0;  // median distance from the prediction, all samples
    double loss_px2 = 0.0;   // mean robust loss: compares two estimates from the same images
    double rate_px_s = 0.0;  // median of the absolute rates: what the delay is measured by
    double flow_px_s = 0.0;  // median of the absolute flow along the baseline
    double speed_m_s = 0.0;  // median
    // Enough features move across the lines, and the last step was below the standard deviation.
    bool is_determined = false;
    std::vector<double> by_moment_s;  // one of each moment; NaN where it has too few features

    // Returns whether the images contradict a delay of 0. Real rigs that are triggered together
    // show up to 1.2 ms, as their calibrations are not exact.
    bool is_significant() const;
};

// Returns the moments without the motion during a known gap between the exposures of each, so that
// the delay estimated from them is the one beyond the gaps.
std::vector<EpipolarMoment> without_gaps(std::vector<EpipolarMoment> moments,
                                         const std::vector<double>& gaps_s);

// Estimates the delay together with the misalignment of the pair (pitch, roll and vertical scale,
// as the right camera sees them), robustly: a constant one, unless another from some moment on fits
// much better. Empty moments are ignored.
StereoDelay estimate_delay(const std::vector<EpipolarMoment>& moments);

}  // namespace divemesh::dive
