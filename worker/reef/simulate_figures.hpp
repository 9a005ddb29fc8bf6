#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "worker/reef/estimate.hpp"
#include "worker/reef/measure_options.hpp"
#include "worker/reef/surface_patch.hpp"

namespace divemesh::worker {

// Figures of the ground whose vertices, patch by patch, are at these places; NaN: cannot be taken.
using Places = std::vector<std::vector<Eigen::Vector3d>>;
using Evaluate = std::function<std::vector<double>(const Places& vertices, bool is_blurred)>;

// Each figure as measured, with noise of the vertices' sigma once and twice over, and blurred. No
// replicates where no vertex has a sigma. The patches share no vertex.
std::vector<Simulated> simulate_figures(const std::vector<SurfacePatch>& patches,
                                        double correlation_length_m,
                                        const MeasureOptions& options,
                                        const Evaluate& evaluate);

}  // namespace divemesh::worker
