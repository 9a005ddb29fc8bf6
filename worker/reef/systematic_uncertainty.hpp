#pragma once

#include <vector>

#include "worker/reef/outline_survey.hpp"
#include "worker/reef/simulate_metrics.hpp"

namespace divemesh::reef {

// Returns one standard deviation of each metric for what is not noise of the vertices:
// - hidden ground: the change if it continued at its lower end instead of being bridged, and the
//   metric's own hidden_deviation;
// - steps: a disparity puts them anywhere in its support, which is two of `detail_m` where only the
//   half size of the images was matched. So each may lie 2 / sqrt(12) of `detail_m` beside its
//   place, and, for metrics without blurring, all farther out or in by that;
// - bends and poses (the vertices' sigma without its noise): random fields of that size, in common
//   over `detail_m`, put on the surface.
std::vector<double> systematic_uncertainty(const OutlineSurvey& survey,
                                           const std::vector<MetricKind>& kinds,
                                           const std::vector<stats::Simulated>& simulated,
                                           const MeasureOptions& options);

// Returns the metric's value; for a direction the equivalent angle (mod 360 degrees) nearest to
// `near`. NaN: not measurable.
double value_of(const MetricKind& kind, const Ground& ground, double near);

}  // namespace divemesh::reef
