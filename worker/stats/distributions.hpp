#pragma once

namespace divemesh::stats {

// Quantile of the normal distribution at 0.975: half the width, in sigmas, of a two-sided 95 %.
inline constexpr double kNormal975 = 1.9599639845400545;

// Return the value that a variable of this distribution stays below with probability `share`; the
// degrees of freedom may be a fraction. NaN where there is no such distribution.
double student_t_quantile(double share, double degrees_of_freedom);
double chi_square_quantile(double share, double degrees_of_freedom);

}  // namespace divemesh::stats
