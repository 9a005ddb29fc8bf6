#pragma once

#include <vector>

#include "worker/markers/marker_metrics.hpp"

namespace divemesh::markers {

// Uncertainties that all bars of a reconstruction share.
struct BarErrors {
    double drift_rate_m2_per_m = 0.0;     // of positions, per metre travelled between their views
    double systematic_scale_sigma = 0.0;  // relative
};

// Returns the measurements of the plan's bars and of the printed sizes of its tags. A bar's own
// sigma covers the readings of both ends, the drift between the places where they were seen, and
// the known distance itself; it weights the bar in the scale. The leave-one-out error uses the
// scale of all other consistent bars. Of three or more bars the worst is removed as inconsistent as
// long as it misses the scale of the others by more than three of its sigmas.
std::vector<BarMetrics> measure_bars(const std::vector<Marker>& markers,
                                     const dive::MarkerPlan& plan,
                                     const BarErrors& errors);

// Sets the leave-one-out error of every bar: measured with the scale of the other consistent bars.
void leave_each_out(std::vector<BarMetrics>& bars);

// Returns the scale factor of least squares over the consistent bars, factor = sum(w m k) / sum(w m
// m), with w = 1 / own sigma^2, m measured and k known; nullopt if no bar was measured.
std::optional<MarkerScale> scale_of(const std::vector<BarMetrics>& bars);

// Returns the scale by scale bars and by printed sizes with a stated sigma, which were certainly
// measured. Without those, returns the scale by the other printed sizes, with the error of a
// printer that fits a sheet to its page.
std::optional<MarkerScale> trusted_scale(const std::vector<BarMetrics>& bars);

// Returns the reason why a result must not be scaled by this factor; nullopt if it may be.
std::optional<Finding> reason_against(const std::optional<MarkerScale>& scale);

}  // namespace divemesh::markers
