#pragma once

#include "worker/evaluation/trajectory_error.hpp"
#include "worker/report/svg_plot.hpp"

namespace divemesh::report {

// Truth and aligned estimate where `error` is given, else the path as it is.
Plot path_from_above(const evaluation::TrajectoryError* error, const types::Trajectory& path);
Plot path_from_the_side(const evaluation::TrajectoryError* error, const types::Trajectory& path);

// With truth: the error over time. Without: how high the rig was.
Plot error_over_time(const evaluation::TrajectoryError* error, const types::Trajectory& path);

// Relative error of translation over length of segment.
Plot error_by_segment(const evaluation::TrajectoryError& error);

}  // namespace divemesh::report
