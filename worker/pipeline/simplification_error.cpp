#include "worker/pipeline/simplification_error.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "worker/evaluation/surface_index.hpp"

namespace divemesh::pipeline {

mesh::SimplificationError simplification_error(const types::Mesh& original,
                                               const types::Mesh& simplified,
                                               int num_threads,
                                               const base::ProgressCallback& progress) {
    const evaluation::SurfaceIndex surface(simplified);
    const std::vector<double> distances_m =
        surface.distances_m(original.vertices, num_threads, {.report = progress});
    mesh::SimplificationError error;
    error.num_triangles_before = std::ssize(original.triangles);
    double sum_of_squares = 0.0;
    for (const double distance_m : distances_m) {
        sum_of_squares += distance_m * distance_m;
        error.max_m = std::max(error.max_m, distance_m);
    }
    error.rms_m = std::sqrt(sum_of_squares / static_cast<double>(distances_m.size()));
    return error;
}

}  // namespace divemesh::pipeline
