#pragma once

#include "worker/evaluation/trajectory_error.hpp"
#include "worker/report/svg_plot.hpp"

namespace divemesh::worker {

// Truth and aligned estimate where `error` is given, else the path as it is.
Plot path_from_above(const TrajectoryError* error, const Trajectory& path);
Plot path_from_the_side(const TrajectoryError* error, const Trajectory& path);

// With truth: the error over time. Without: how high the rig was.
Plot error_over_time(const TrajectoryError* error, const Trajectory& path);

// Relative error of translation over length of segment.
Plot error_by_segment(const TrajectoryError& error);

}  // namespace divemesh::worker
