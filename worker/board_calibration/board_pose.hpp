#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "worker/boards/find_board.hpp"
#include "worker/types/camera.hpp"

namespace divemesh::board_calibration {

inline constexpr std::size_t kMinCorners = 8;  // for a pose that the lens can be judged by

// A board relative to a camera, by one image.
struct BoardPose {
    Eigen::Isometry3d T_cam_board = Eigen::Isometry3d::Identity();
    double rms_px = 0.0;  // over both axes
};

// Returns the pose of a flat board (T. Collins and A. Bartoli, "Infinitesimal plane-based pose
// estimation", 2014, as OpenCV has it); nullopt for fewer than kMinCorners corners, or if they lie
// on a line or behind the camera.
std::optional<BoardPose> find_board_pose(const types::Camera& camera,
                                         const boards::Board& board,
                                         const boards::BoardCorners& corners);

}  // namespace divemesh::board_calibration
