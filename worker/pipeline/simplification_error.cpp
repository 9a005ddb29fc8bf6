#include "worker/pipeline/simplification_error.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "worker/base/parallel.hpp"
#include "worker/evaluation/surface_index.hpp"

namespace divemesh::pipeline {

mesh::SimplificationError simplification_error(const types::Mesh& original,
                                               const types::Mesh& simplified,
                                               int num_threads,
                                               const base::ProgressCallback& progress) {
    const evaluation::SurfaceIndex surface(simplified);
    std::vector<float> distances_m(original.vertices.size());
    base::for_each_index(num_threads, distances_m.size(), {.report = progress}, [&](std::size_t i) {
        distances_m[i] = surface.distance_m(original.vertices[i]);
    });
    mesh::SimplificationError error;
    error.num_triangles_before = std::ssize(original.triangles);
    double sum_of_squares = 0.0;
    for (const float distance_m : distances_m) {
        sum_of_squares += static_cast<double>(distance_m) * distance_m;
        error.max_m = std::max(error.max_m, static_cast<double>(distance_m));
    }
    error.rms_m = std::sqrt(sum_of_squares / static_cast<double>(distances_m.size()));
    return error;
}

}  // namespace divemesh::pipeline
