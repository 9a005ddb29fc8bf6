#pragma once

#include <vector>

#include "worker/compare/change_map.hpp"

namespace divemesh::compare {

// Ground of one kind: equally steep and equally near to the end of the compared ground. Both cause
// errors that the vertices' sigma does not include: at a step a small shift is a large change, and
// beside hidden ground a mesh bridges it.
struct ScatterClass {
    double min_range_m = 0.0;  // of heights within the scale, of either surface
    bool at_edge = false;      // closer than the scale to ground that is not compared
    std::size_t num_cells = 0;
    double factor = 1.0;  // for a cell's sigma
};

// Multiplies the map's sigma so that it is the scatter of the difference of heights on ground of
// that kind: heteroscedastic errors, standardised by class (Hugonnet et al. 2022). Most ground
// of a kind is stable, so its scatter follows from the median and the 80th percentile of its
// differences. A class of fewer than 200 cells takes the factor of the next less steep class, the
// least steep keeps the stated sigma. `scale_m`: the size over which the range of heights is taken.
// Reads change_m, heights and sigma_m.
std::vector<ScatterClass> scale_by_scatter(ChangeMap& map,
                                           const SurfaceRaster& a,
                                           const SurfaceRaster& b,
                                           double scale_m);

// Returns the standard deviation of normal errors from the median and from the 80th percentile of
// their absolute values, whichever is larger. Reorders the values; returns 0 without values.
double robust_sigma(std::vector<float>& sizes);

}  // namespace divemesh::compare
