#pragma once

#include <vector>

namespace divemesh::stats {

// A value with its 95 % confidence interval.
struct Estimate {
    double value = 0.0;
    double low = 0.0;
    double high = 0.0;
};

// A metric of a surface with noise and limited resolution: as measured; sharpened, i.e. corrected
// for the detail that the surface cannot resolve; and the sharpened metric with the same noise
// added once more, and with twice its variance, one value per replicate.
struct Simulated {
    double measured = 0.0;
    double sharp = 0.0;  // = measured if the resolution is unknown
    std::vector<double> once;
    std::vector<double> twice;
};

// Returns a metric corrected for blurring, given its values after blurring once and twice more.
// Extrapolates one step back along the parabola through the three, as SIMEX does with noise (Cook
// and Stefanski 1994). The correction is at least that of Tukey's twicing (1977), which uses the
// first blurring alone, and at most twice as much.
double sharpened(double measured, double blurred, double blurred_twice);

// Returns the estimate with the interval widened by an error that it shares with all others, a
// fraction `relative_sigma` of the value.
Estimate with_shared_error(const Estimate& estimate, double relative_sigma);

// The effect on a metric of errors that all vertices share: one standard deviation.
struct SharedError {
    double relative = 0.0;  // a fraction of the metric
    double absolute = 0.0;
};

// Returns the sharpened metric extrapolated to zero noise by the parabola through the three (SIMEX;
// Cook and Stefanski 1994): noise only ever raises rugosity. The interval combines Student's t over
// the spread of the replicates, the relative error `sigma_relative_error` of the noise level (it
// enters its part twice), the correction by sharpening as one standard deviation, and the shared
// errors.
Estimate estimate(const Simulated& simulated,
                  double sigma_relative_error,
                  const SharedError& shared = {});

}  // namespace divemesh::stats
