#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "worker/reef/measure_options.hpp"
#include "worker/reef/surface_patch.hpp"
#include "worker/stats/estimate.hpp"

namespace divemesh::reef {

// Returns the metrics of the ground with the vertices, patch by patch, at these places; NaN: not
// measurable.
using Places = std::vector<std::vector<Eigen::Vector3d>>;
using Evaluate = std::function<std::vector<double>(const Places& vertices, int num_blurs)>;

// Returns each metric as measured and sharpened; the sharpened one also with noise of once and
// twice the vertices' local sigma. Calls `evaluate` with blurs if `has_blur`. Makes no replicates
// if no vertex has a sigma. The patches share no vertex.
std::vector<stats::Simulated> simulate_metrics(const std::vector<SurfacePatch>& patches,
                                               double correlation_length_m,
                                               bool has_blur,
                                               const MeasureOptions& options,
                                               const Evaluate& evaluate);

// Returns the standard deviation of each metric over replicates, each with the same metrics; 0
// where one is not finite, empty without replicates.
std::vector<double> standard_deviations(const std::vector<std::vector<double>>& replicates);

// Returns the standard deviation of each metric over surfaces moved by the vertices' sigma_bend, in
// common over `alike_m`; empty if no vertex has a sigma_bend.
std::vector<double> bend_deviations(
    const std::vector<SurfacePatch>& patches,
    double alike_m,
    const MeasureOptions& options,
    const std::function<std::vector<double>(const Places& vertices)>& evaluate);

}  // namespace divemesh::reef
