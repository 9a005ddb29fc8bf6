#pragma once

namespace divemesh::types {

// Relative sigma of all lengths where a path does not state its own: baseline and focal length of a
// careful calibration.
inline constexpr double kCalibrationSigma = 0.0025;

// The expected error of a trajectory after it is aligned with the true one by the best SE(3) of
// positions, as the absolute trajectory error is defined. With P the covariance of all n positions
// and N the projection that removes the six rigid motions of such an alignment,
//
//     ATE^2 = e' N e / n,   E = tr(N P) / n
//
// a weighted sum of squares of normal variables, distributed about as E chi^2_h / h with h = tr(N
// P)^2 / tr(N P N P) degrees of freedom (Satterthwaite 1946).
struct PathUncertainty {
    double mean_square_m2 = 0.0;        // E; 0: unknown
    double degrees_of_freedom = 0.0;    // h
    double vertical_scale_sigma = 0.0;  // of the vertical scale, calibration exact; 0: unknown
    double scale_sigma = 0.0;           // of the scale of the whole path; 0: unknown
    // The part of scale_sigma that does not come from the drift of the poses: all lengths share it,
    // short ones too, and another measurement of lengths replaces it.
    double shared_scale_sigma = 0.0;
    // Mean square distance of the positions from their centre: the shared error has the part
    // shared_scale_sigma^2 spread_m2 of E.
    double spread_m2 = 0.0;
    // The largest difference, relative, of another measurement of lengths that contradicts this
    // scale; 0: none does. Nothing above contains it.
    double scale_contradiction = 0.0;

    bool is_known() const { return degrees_of_freedom > 0.0; }
    double scale_sigma_or_typical() const {
        return scale_sigma > 0.0 ? scale_sigma : kCalibrationSigma;
    }
};

}  // namespace divemesh::types
