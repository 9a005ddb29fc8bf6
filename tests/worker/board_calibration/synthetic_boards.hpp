#pragma once

#include <opencv2/core/mat.hpp>
#include <random>
#include <vector>

#include "worker/board_calibration/rig_parameters.hpp"
#include "worker/boards/board_recording.hpp"

namespace divemesh::board_calibration {

// Returns a checkerboard of 9 x 7 corners, 40 mm apart.
boards::Board known_checkerboard();

// Returns a rig of two cameras of 1280 x 960 px, 0.15 m apart.
RigParameters known_rig(types::Distortion distortion);

// Returns poses of a board, T_cam0_board, all over both images: 0.5 to 2 m away, tilted up to 40
// degrees.
std::vector<Eigen::Isometry3d> drawn_poses(const boards::Board& board,
                                           std::size_t num,
                                           std::mt19937_64& random);

// Returns what the rig sees of the board in those poses, with normal errors of corners. A
// checkerboard is seen in whole or not at all.
std::vector<boards::BoardView> drawn_views(const RigParameters& rig,
                                           const boards::Board& board,
                                           const std::vector<Eigen::Isometry3d>& T_cam0_board,
                                           double sigma_px,
                                           std::mt19937_64& random);

// Returns the rays of 5 x 5 pixels all over an image.
std::vector<Eigen::Vector3d> rays_over(const types::Camera& camera);

// The rays of a camera before the lens, at the corners of its pixels and linear between them.
class ImageRays {
public:
    explicit ImageRays(const types::Camera& camera);

    int width_px() const { return width_px_; }
    int height_px() const { return static_cast<int>(at_.size()) / (width_px_ + 1) - 1; }
    // Returns the ray, at z = 1, through a point that is so far from the image's upper left corner.
    Eigen::Vector3d ray(double column, double row) const;

private:
    int width_px_;
    std::vector<Eigen::Vector2d> at_;
};

// Returns the image of a board on grey ground through a lens: the mean of 4 x 4 rays a pixel.
cv::Mat rendered_board(const ImageRays& rays,
                       const boards::Board& board,
                       const Eigen::Isometry3d& T_cam_board);

}  // namespace divemesh::board_calibration
