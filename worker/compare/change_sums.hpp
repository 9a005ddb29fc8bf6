#pragma once

#include "worker/compare/change_map.hpp"
#include "worker/compare/change_noise.hpp"
#include "worker/stats/estimate.hpp"

namespace divemesh::compare {

// The change summed over some cells of the ground.
struct ChangeSums {
    double volume_m3 = 0.0;                 // rise minus fall
    double sigma_m = 0.0;                   // mean over the cells
    Vector6d by_motion = Vector6d::Zero();  // volume by a small rotation (rad) and shift (m) of b
    double area_m2 = 0.0;
    double max_change_m = 0.0;  // signed
};

// Sums over the cells that `cells` (CV_8U, of the map's size) selects; both dives saw each of them.
ChangeSums sum_over(const ChangeMap& map, const cv::Mat& cells);

// Returns a part of the map, with its place, which shares the cells.
ChangeMap window_of(const ChangeMap& map, const cv::Rect& window);

// Returns the standard deviation of the volume from errors of the meshes, m3.
double noise_m3(const ChangeSums& sums, const ChangeNoise& noise);

// Returns the 95 % interval; `noise` and `shared` are independent standard deviations.
stats::Estimate interval(double value, double noise, double shared);

}  // namespace divemesh::compare
