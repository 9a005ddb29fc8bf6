#pragma once

namespace divemesh::stats {

// The 0.975 quantile of the normal distribution: half the width of a two-sided 95 % interval, in
// sigmas.
inline constexpr double kNormal975 = 1.9599639845400545;

// Return the quantile of the distribution at probability `share`. The degrees of freedom may be
// fractional. NaN for arguments outside the distribution's domain.
double normal_quantile(double share);
double student_t_quantile(double share, double degrees_of_freedom);
double chi_square_quantile(double share, double degrees_of_freedom);

}  // namespace divemesh::stats
