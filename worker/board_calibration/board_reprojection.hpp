#pragma once

#include <Eigen/Core>
#include <ceres/cost_function.h>
#include <memory>

#include "worker/types/camera.hpp"

namespace divemesh::board_calibration {

// Returns the reprojection error of a corner of a board in the left camera, px:
//
//     r = lens0(T_cam0_board p_board) - pixel
//
// Blocks: lens0 with as many values as its model has, T_cam0_board. Invalid for a point behind the
// camera.
std::unique_ptr<ceres::CostFunction> left_board_reprojection(types::Distortion distortion,
                                                             const Eigen::Vector3d& p_board,
                                                             const Eigen::Vector2d& pixel);

// Returns the same in the right camera:
//
//     r = lens1(T_cam1_cam0 T_cam0_board p_board) - pixel
//
// Blocks: lens1, T_cam1_cam0, T_cam0_board.
std::unique_ptr<ceres::CostFunction> right_board_reprojection(types::Distortion distortion,
                                                              const Eigen::Vector3d& p_board,
                                                              const Eigen::Vector2d& pixel);

}  // namespace divemesh::board_calibration
