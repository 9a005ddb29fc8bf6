#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "worker/reef/measure_options.hpp"
#include "worker/reef/surface_patch.hpp"
#include "worker/stats/estimate.hpp"

namespace divemesh::reef {

// Figures of the ground whose vertices, patch by patch, are at these places; NaN: cannot be taken.
using Places = std::vector<std::vector<Eigen::Vector3d>>;
using Evaluate = std::function<std::vector<double>(const Places& vertices, int num_blurs)>;

// Each figure as measured and sharpened, the latter with noise of the vertices' local sigma once
// and twice over as well. `evaluate` is asked for blurs where `has_blur`. No replicates where no
// vertex has a sigma. The patches share no vertex.
std::vector<stats::Simulated> simulate_metrics(const std::vector<SurfacePatch>& patches,
                                               double correlation_length_m,
                                               bool has_blur,
                                               const MeasureOptions& options,
                                               const Evaluate& evaluate);

// Standard deviation of each figure over surfaces moved by the vertices' sigma_bend, alike over
// `alike_m`. Empty where no vertex has one.
std::vector<double> bend_deviations(
    const std::vector<SurfacePatch>& patches,
    double alike_m,
    const MeasureOptions& options,
    const std::function<std::vector<double>(const Places& vertices)>& evaluate);

}  // namespace divemesh::reef
