#pragma once

#include <Eigen/Core>
#include <optional>

#include "worker/reef/height_grid.hpp"

namespace divemesh::reef {

// Terrain measures of geography from windows of 3 x 3 samples over the plane, all nine of them
// seen.
struct Terrain {
    double mean_slope = 0.0;  // rad, against the plane, by central differences (Horn 1981)
    // 1/m, minus the sum of the second derivatives (Zevenbergen and Thorne 1987); positive on
    // hills.
    double mean_curvature = 0.0;
    double curvature_deviation = 0.0;  // standard deviation
    // Vector ruggedness measure: 1 - |sum of the nine normals| / 9 (Sappington, Longshore and
    // Thompson 2007), the mean over the windows whose normals are known.
    double vrm = 0.0;
};
// Returns the means over all windows; nullopt if the ruggedness of no window is known.
std::optional<Terrain> terrain(const HeightGrid& grid);

// Returns the unit normal of the plane that fits the heights best (least squares along z); nullopt
// with fewer than three samples or all on one line.
std::optional<Eigen::Vector3d> mean_normal(const HeightGrid& grid);

}  // namespace divemesh::reef
