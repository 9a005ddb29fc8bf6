#pragma once

#include <Eigen/Core>
#include <optional>

#include "worker/reef/height_grid.hpp"

namespace divemesh::reef {

// What geographers measure in windows of 3 x 3 samples, all nine of them seen, over the plane.
struct Terrain {
    double mean_slope = 0.0;  // rad, of the plane by central differences (Horn 1981)
    // 1/m, minus the sum of the second derivatives (Zevenbergen and Thorne 1987), hills positive.
    double mean_curvature = 0.0;
    double curvature_deviation = 0.0;  // standard deviation
    // Vector ruggedness measure: 1 - |sum of the nine normals| / 9 (Sappington, Longshore and
    // Thompson 2007), the mean over the windows whose normals are known.
    double vrm = 0.0;
};
std::optional<Terrain> terrain(const HeightGrid& grid);

// Unit normal of the plane that fits the heights best (least squares along z); nothing with fewer
// than three samples or all on a line.
std::optional<Eigen::Vector3d> mean_normal(const HeightGrid& grid);

}  // namespace divemesh::reef
