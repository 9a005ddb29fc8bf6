#pragma once

#include <vector>

namespace divemesh::stats {

// A figure and the interval that holds the truth with 95 %.
struct Estimate {
    double value = 0.0;
    double low = 0.0;
    double high = 0.0;
};

// A figure of a surface with noise and of limited detail: as measured; with the detail put back
// (sharpened) that the surface cannot hold; the latter of the measured surface with the same noise
// added once more, and with twice its variance, replicate by replicate.
struct Simulated {
    double measured = 0.0;
    double sharp = 0.0;  // = measured where nothing is known of the resolution
    std::vector<double> once;
    std::vector<double> twice;
};

// A figure with what blurring took from it put back, by what blurring once and twice more takes:
// one step back along the parabola through the three, as simulation and extrapolation goes with
// noise (Cook and Stefanski 1994); once more alone is Tukey's twicing (1977). Never less than that
// and never more than twice as much.
double sharpened(double measured, double blurred, double blurred_twice);

// What errors that all vertices share do to a figure: one standard deviation.
struct SharedError {
    double relative = 0.0;  // of the figure itself
    double absolute = 0.0;
};

// Noise raises rugosity and lowers nothing, so the sharpened figure is taken back to noise of no
// variance by the parabola through the three (SIMEX; Cook and Stefanski 1994). The interval:
// Student's t over the spread of the replicates; `sigma_relative_error` of the noise's size, which
// goes into its part twice; what sharpening put back as one standard deviation; the shared errors.
Estimate estimate(const Simulated& simulated,
                  double sigma_relative_error,
                  const SharedError& shared = {});

}  // namespace divemesh::stats
