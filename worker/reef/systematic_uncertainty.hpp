#pragma once

#include <vector>

#include "worker/reef/outline_survey.hpp"
#include "worker/reef/simulate_metrics.hpp"

namespace divemesh::reef {

// One standard deviation of each figure for what is no noise of the vertices:
// - hidden ground: what it would change to go on at its lower end instead of being bridged;
// - steps, of figures that blurring is not asked of: a disparity puts them anywhere in its support,
//   so that all may lie 1 / sqrt(12) of `detail_m` farther out or in;
// - what bends lose and poses move (the vertices' sigma less its noise): a field of that size,
// alike
//   over `detail_m`, put on the surface time and again.
std::vector<double> systematic_uncertainty(const OutlineSurvey& survey,
                                           const std::vector<MetricKind>& kinds,
                                           const std::vector<stats::Simulated>& simulated,
                                           const MeasureOptions& options);

// The figure; a direction as the turn of 360 degrees nearest to `near`. NaN: cannot be taken.
double value_of(const MetricKind& kind, const Ground& ground, double near);

}  // namespace divemesh::reef
