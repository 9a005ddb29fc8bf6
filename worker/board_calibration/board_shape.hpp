#pragma once

#include <optional>
#include <vector>

#include "worker/board_calibration/rig_problem.hpp"

namespace divemesh::board_calibration {

// The shape of a board as both cameras triangulate it: the mean over the views of each corner.
struct BoardShape {
    int num_corners = 0;
    int num_views = 0;
    double flatness_rms_m = 0.0;  // distance of corners from the plane of best fit
    double flatness_max_m = 0.0;
    double step_error = 0.0;   // mean of measured over stated steps between corners, minus 1
    double step_spread = 0.0;  // standard deviation of that ratio
};

// Returns nullopt if no view shows enough of the board to both cameras.
std::optional<BoardShape> board_shape(const boards::Board& board,
                                      const types::Camera& cam0,
                                      const types::Camera& cam1,
                                      const Eigen::Isometry3d& T_cam1_cam0,
                                      const std::vector<boards::BoardView>& views);

}  // namespace divemesh::board_calibration
