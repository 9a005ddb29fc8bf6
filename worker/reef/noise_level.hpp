#pragma once

#include <vector>

#include "worker/reef/surface_patch.hpp"

namespace divemesh::reef {

// How much of the stated noise a surface shows. A vertex's sigma is derived from the max error of
// matching; meshing smooths much of it, and calm water leaves less of it. Noise of standard
// deviation sigma and correlation length L makes second differences over 2 L of sigma sqrt(6 - 8
// e^-4 + 2 e^-16). The real shape of the ground only adds to them. So the lower quartile of their
// size, which the smooth parts of the ground determine, is no less than that of the noise (as image
// noise is distinguished from texture: Immerkaer 1996, Olsen 1993).
class NoiseLevel {
public:
    explicit NoiseLevel(double correlation_length_m) : lag_m_(2.0 * correlation_length_m) {}

    // Adds every second difference along rows and columns of the patch's heights at these nodes.
    void add(const SurfacePatch& patch, const GridShape& shape);

    // Returns the share of the stated local sigma that can be present, 0 to 1; 1 if too few
    // differences were added.
    double share() const;

private:
    void add_along(const HeightGrid& heights, const HeightGrid& sigmas, int columns, int rows);

    double lag_m_;
    std::vector<double> sizes_;  // relative to the second differences of the stated sigma
};

}  // namespace divemesh::reef
