#pragma once

#include "worker/evaluation/trajectory_error.hpp"
#include "worker/report/svg_plot.hpp"

namespace divemesh::report {

// Plot truth and aligned estimate if `error` is given, otherwise the path as it is.
Plot path_from_above(const evaluation::TrajectoryError* error, const types::Trajectory& path);
Plot path_from_the_side(const evaluation::TrajectoryError* error, const types::Trajectory& path);

// Plots the error over time if `error` is given, otherwise the height of the rig.
Plot error_over_time(const evaluation::TrajectoryError* error, const types::Trajectory& path);

// Plots the relative error of translation over the length of segments.
Plot error_by_segment(const evaluation::TrajectoryError& error);

}  // namespace divemesh::report
