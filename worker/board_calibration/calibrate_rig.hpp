#pragma once

#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <vector>

#include "worker/base/parallel.hpp"
#include "worker/board_calibration/lens_estimate.hpp"
#include "worker/board_calibration/rig_problem.hpp"

namespace divemesh::board_calibration {

// The errors that a lens model leaves in both cameras, each estimated by itself.
struct ModelFit {
    types::Distortion distortion = types::Distortion::RadialTangential;
    double left_rms_px = 0.0;
    double right_rms_px = 0.0;
};

// A view whose corners contradict the others.
struct ViewLeftOut {
    std::int64_t timestamp_ns = 0;
    double rms_px = 0.0;
    double median_rms_px = 0.0;  // of the views that are used
};

// A stereo rig by what it saw of a board, or why it is not determined.
struct RigEstimate {
    std::string failure;  // "" if the rig is determined and the solver converged
    RigParameters rig;
    RigCovariance covariance;      // empty if there is none
    std::vector<ModelFit> models;  // that were compared, the chosen one first
    double sigma_px = 0.0;         // of one axis of a corner
    std::vector<PosedView> views;  // that are used, in the order of time
    std::vector<CornerError> errors;
    std::vector<ViewLeftOut> left_out;
    int num_corners_left_out = 0;
};

// Estimates lenses, relative pose and board poses together, with Huber's loss. Views whose errors
// are three times those of the others, and corners six standard deviations off, are left out.
// `model`: nullopt takes radial-tangential or equidistant, whichever leaves the smaller errors.
RigEstimate calibrate_rig(const boards::Board& board,
                          const std::vector<boards::BoardView>& views,
                          cv::Size left_size,
                          cv::Size right_size,
                          std::optional<types::Distortion> model,
                          const base::ProgressShare& progress);

}  // namespace divemesh::board_calibration
