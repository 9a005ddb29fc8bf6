#pragma once

#include <string>

#include "worker/evaluation/surface_error.hpp"

namespace divemesh::report {

// The mesh from above, coloured by its distance to the reference: 0 dark blue, `end_m` and more
// yellow (viridis, S. van der Walt and N. Smith 2015). It is grey where every camera is beyond the
// limit of range, white where there is no surface.
struct ErrorMap {
    std::string png;
    double end_m = 0.0;  // the 90th percentile, rounded up to 1, 2 or 5 times a power of ten
};

// Renders the map; `input` has the cameras and the limit of range.
ErrorMap render_error_map(const types::Mesh& mesh_world,
                          const types::Mesh& reference,
                          const evaluation::SurfaceErrorInput& input);

// Returns the colours of the scale, evenly from 0 to `end_m`, "#rrggbb".
std::vector<std::string> error_map_colors();

}  // namespace divemesh::report
