#pragma once

#include <optional>
#include <vector>

#include "worker/board_calibration/rig_problem.hpp"

namespace divemesh::board_calibration {

// A lens by what its camera alone saw of the board.
struct LensEstimate {
    LensKind kind;
    LensValues values = {};
    std::vector<std::optional<PoseValues>> T_cam_board;  // by view; nullopt: not used
    double rms_px = 0.0;  // of one axis, with outliers counted as five standard deviations
    std::size_t num_corners = 0;
    bool converged = false;
};

// Returns the standard deviation of one axis by the median of the errors' lengths, which outliers
// do not move; 0 for none.
double noise_px(const std::vector<CornerError>& errors);

// Estimates the lens of a camera by its corners in each view (Zhang, "A flexible new technique for
// camera calibration", 2000): the focal length that explains most views where the model starts,
// then least squares of all. nullopt if fewer than three views show enough of the board.
std::optional<LensEstimate> estimate_lens(const boards::Board& board,
                                          const std::vector<boards::BoardCorners>& views,
                                          const LensKind& kind);

}  // namespace divemesh::board_calibration
