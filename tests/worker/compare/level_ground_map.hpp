#pragma once

#include "worker/compare/change_map.hpp"

namespace divemesh::compare {

// Returns the map of level ground around the origin that has not changed. The pivot of the
// co-registration is the origin; its error is `covariance`.
inline ChangeMap level_ground_map(
    double cell_m, int rows, int columns, float sigma_m, const Matrix6d& covariance) {
    const auto of = [&](int type, double value) {
        return cv::Mat(rows, columns, type, cv::Scalar::all(value));
    };
    ChangeMap map{.grid = {cell_m, {-0.5 * cell_m * columns, 0.5 * cell_m * rows}, rows, columns},
                  .state = of(CV_8U, static_cast<double>(CellState::Stable)),
                  .change_m = of(CV_32F, 0.0),
                  .sigma_m = of(CV_32F, static_cast<double>(sigma_m)),
                  .registration_m = of(CV_32F, 0.0),
                  .later_surface = of(CV_32FC3, 0.0),
                  .registration_covariance = covariance};
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column)
            map.registration_m.at<float>(row, column) =
                static_cast<float>(map.registration_sigma(map.change_by_motion(row, column)));
    return map;
}

// Returns the covariance of rotations (rad) and shifts (m) along x, y and z that err independently.
inline Matrix6d independent(const Vector6d& sigmas) { return sigmas.cwiseAbs2().asDiagonal(); }

}  // namespace divemesh::compare
