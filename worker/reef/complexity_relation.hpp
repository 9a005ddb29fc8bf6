#pragma once

namespace divemesh::reef {

// The relation between rugosity R, fractal dimension D and height range H of a surface
// (Torres-Pulliza et al. 2020; habtools rdh_theory). The height range within squares of the
// resolution L0 follows from that of the extent L by H0 = H (L0 / L)^(3 - D), and R = sqrt(1 + H0^2
// / (2 L0^2)).
double rugosity_of_height_range(double range_m, double resolution_m);  // H0, L0

// The extent and the resolution of a surface.
struct Scales {
    double extent_m = 1.0;       // L
    double resolution_m = 0.01;  // L0
};
// Returns D from R at L0 and H at L.
double fractal_dimension_from(double rugosity, double height_range_m, const Scales& scales);

}  // namespace divemesh::reef
