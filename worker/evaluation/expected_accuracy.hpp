#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "schemas/finding.hpp"
#include "worker/evaluation/expected_surface.hpp"
#include "worker/evaluation/scale_sources.hpp"
#include "worker/types/mesh.hpp"
#include "worker/types/optimised_track.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/track.hpp"

namespace divemesh::evaluation {

struct ExpectedAccuracyInput {
    const types::Recording& recording;
    const types::Trajectory& trajectory;  // final
    std::size_t num_segments = 1;
    double path_length_m = 0.0;                 // of the trajectory, over what was measured
    const types::CovarianceTrack& covariances;  // of the trajectory; empty: unknown
    const types::TrackStatistics& track;
    const types::OptimiseStatistics& optimise;
    const ScaleSources& scale;
    const types::Mesh* mesh = nullptr;  // null: no surface was requested
};

// The accuracy of a reconstruction as estimated from its own data, without ground truth. Bounds
// hold in 95 of 100 dives. If loops were closed and the final trajectory misses them by more than
// their own sigma, the covariances are scaled up accordingly. Where a measurement of lengths
// contradicts the path's scale (PathUncertainty::scale_contradiction), bounds and scale cover both.
struct ExpectedAccuracy {
    std::optional<double> end_bound_m;      // last position relative to the first pose
    std::optional<double> end_expected_m;   // the same as RMS over many such dives
    std::optional<double> ate_bound_m;      // RMS over all frames after the best SE(3) of positions
    std::optional<double> ate_expected_m;   // the same as RMS over many such dives
    std::optional<double> loop_residual_m;  // RMS over the closed loops
    std::optional<double> covariance_scale;  // of standard deviations, from the loops
    std::optional<ScaleCheck> cameras;  // scale 1; sigma by calibration, path and contradiction
    std::vector<ScaleSource> scales;    // with the cameras' own sigma: 1 must be within theirs
    std::optional<double> imu_vision_disagreement_deg;  // RMS per frame
    std::optional<double> reprojection_rms_px;
    std::optional<ExpectedSurface> surface;
    // Part of the sigma by which the poses move the whole surface, without the contradiction: that
    // is in the scale of all lengths.
    std::optional<double> surface_shared_m;
    std::vector<LeftOut> left_out;
    std::vector<Finding> findings;  // checks that contradict the cameras, large bounds
};

// Estimates the accuracy of a reconstruction; metrics that cannot be given are in `left_out`.
ExpectedAccuracy expected_accuracy(const ExpectedAccuracyInput& input);

nlohmann::json to_metrics(const ExpectedAccuracy& expected);

}  // namespace divemesh::evaluation
