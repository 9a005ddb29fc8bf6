#pragma once

#include <vector>

#include "worker/compare/change_map.hpp"

namespace divemesh::compare {

// Ground of one kind: as steep, as near to where the compared ground ends. Both are what a mesh
// errs by that its vertices' sigma does not know: at a step a small shift is a large change, and
// beside ground that was hidden a mesh bridges it.
struct ScatterClass {
    double min_range_m = 0.0;  // of heights within the scale, of either surface
    bool at_edge = false;      // within the scale of ground that is not compared
    std::size_t num_cells = 0;
    double factor = 1.0;  // what a cell's sigma is to be multiplied by
};

// Multiplies the map's sigma so that it says how far the difference of heights scatters on ground
// of that kind: heteroscedastic errors, standardised by class (Hugonnet et al. 2022). Most of the
// ground of a kind is stable, so that the middle and four fifths of its differences tell. A class
// of fewer than 200 cells takes the factor of the next less steep, the least steep what was stated.
// `scale_m`: over which heights range. Reads change_m, heights and sigma_m.
std::vector<ScatterClass> scale_by_scatter(ChangeMap& map,
                                           const SurfaceRaster& a,
                                           const SurfaceRaster& b,
                                           double scale_m);

// For normal errors one standard deviation, as the median and four fifths of their sizes tell it;
// the larger. Reorders the values; 0 of none.
double robust_sigma(std::vector<float>& sizes);

}  // namespace divemesh::compare
