#pragma once

#include "worker/compare/change_map.hpp"
#include "worker/compare/change_noise.hpp"
#include "worker/stats/estimate.hpp"

namespace divemesh::compare {

// The change of some cells of the ground.
struct ChangeSums {
    double volume_m3 = 0.0;       // rise less fall
    double sigma_m = 0.0;         // mean of the cells' own
    double registration_m = 0.0;  // mean
    double area_m2 = 0.0;
    double max_change_m = 0.0;  // with its sign
};

// Over the cells that `cells` (CV_8U, of the map's size) names; both dives saw each of them.
ChangeSums sum_over(const ChangeMap& map, const cv::Mat& cells);

// A part of the map; its cells are the map's own.
ChangeMap window_of(const ChangeMap& map, const cv::Rect& window);

// Standard deviations of the volume: by what the meshes get wrong, by what the registration does.
double noise_m3(const ChangeSums& sums, const ChangeNoise& noise);
double registration_m3(const ChangeSums& sums);

// 95 %; `noise` and `shared` are standard deviations that have nothing to do with each other.
stats::Estimate interval(double value, double noise, double shared);

}  // namespace divemesh::compare
