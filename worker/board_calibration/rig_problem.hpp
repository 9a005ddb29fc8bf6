#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "worker/board_calibration/rig_parameters.hpp"
#include "worker/boards/board_recording.hpp"

namespace divemesh::board_calibration {

// A view of the board with its pose.
struct PosedView {
    boards::BoardView view;
    PoseValues T_cam0_board = {};
};

// The reprojection error of a corner.
struct CornerError {
    std::size_t view = 0;
    bool is_right = false;
    int corner = 0;
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
    Eigen::Vector2d error_px = Eigen::Vector2d::Zero();  // projected minus seen
};

struct SolveOutcome {
    bool converged = false;
    std::string message;  // of the solver
};

inline constexpr double kHuberSigmas = 3.0;

// Moves rig and poses to the least sum of reprojection errors, with Huber's loss from `huber_px`
// on, which is kHuberSigmas times the noise of a corner. Without right corners the right camera
// stays, without left ones the left one.
SolveOutcome solve_rig(const boards::Board& board,
                       double huber_px,
                       RigParameters& rig,
                       std::vector<PosedView>& views);

// Returns the error of every corner, by view, left ones first. A corner behind its camera has a
// large one.
std::vector<CornerError> corner_errors(const boards::Board& board,
                                       const RigParameters& rig,
                                       const std::vector<PosedView>& views);

// Returns the covariance of the rig for corners of a standard deviation of `sigma_px`; increased
// by what views disagree beyond that (White 1980, with views as clusters). nullopt if the views do
// not determine the rig.
std::optional<RigCovariance> rig_covariance(const boards::Board& board,
                                            double sigma_px,
                                            const RigParameters& rig,
                                            const std::vector<PosedView>& views);

}  // namespace divemesh::board_calibration
