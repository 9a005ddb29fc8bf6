#pragma once

#include <vector>

#include "worker/markers/marker_metrics.hpp"

namespace divemesh::markers {

// Sigmas that all bars of a reconstruction share.
struct BarErrors {
    double drift_rate_m2_per_m = 0.0;     // of positions, by the way swum between their views
    double systematic_scale_sigma = 0.0;  // relative
};

// The bars of the plan and the printed sizes of its tags. Own sigma: of both ends' readings, of the
// drift between where they were seen, of the known distance itself. The scale is weighted by it;
// leave-one-out takes that of all other consistent bars. Consistent: of three and more the worst is
// taken out as long as it misses the others' scale by more than three of its sigmas.
std::vector<BarMetrics> measure_bars(const std::vector<Marker>& markers,
                                     const dive::MarkerPlan& plan,
                                     const BarErrors& errors);

// Sets the leave-one-out error of every bar: measured with the scale of the consistent others.
void leave_each_out(std::vector<BarMetrics>& bars);

// factor = sum(w m k) / sum(w m m), w = 1 / own sigma^2 over measured m and known k: the factor of
// least squares over the consistent bars. Nothing without a measured one.
std::optional<MarkerScale> scale_of(const std::vector<BarMetrics>& bars);

// Why a result is not to be scaled by this; nothing: it may be.
std::optional<Finding> reason_against(const std::optional<MarkerScale>& scale);

}  // namespace divemesh::markers
