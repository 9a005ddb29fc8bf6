#pragma once

namespace divemesh::types {

// How far a path is expected to be from the true one when it is laid on it by the best SE(3) of
// positions, as its absolute trajectory error is measured. With P the covariance of all n positions
// and N the projection across the six rigid motions, which such an alignment takes away,
//
//     ATE^2 = e' N e / n,   E = tr(N P) / n
//
// a weighted sum of squares of normal numbers, about as E chi^2_h / h with
// h = tr(N P)^2 / tr(N P N P) degrees of freedom (Satterthwaite 1946).
struct PathUncertainty {
    double mean_square_m2 = 0.0;        // E; 0: not known
    double degrees_of_freedom = 0.0;    // h
    double vertical_scale_sigma = 0.0;  // see below; 0: not known

    bool is_known() const { return degrees_of_freedom > 0.0; }
};

}  // namespace divemesh::types
