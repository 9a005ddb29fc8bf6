#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "schemas/finding.hpp"
#include "worker/evaluation/expected_surface.hpp"
#include "worker/evaluation/scale_check.hpp"
#include "worker/types/mesh.hpp"
#include "worker/types/optimised_track.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/track.hpp"

namespace divemesh::evaluation {

struct ExpectedAccuracyInput {
    const types::Recording& recording;
    const types::Trajectory& trajectory;  // final
    std::size_t num_segments = 1;
    const types::CovarianceTrack& covariances;  // of the trajectory; empty: not known
    const types::TrackStatistics& track;
    const types::OptimiseStatistics& optimise;
    const KnownDistanceErrors* known_distances = nullptr;  // none: the dive brings none
    const types::Mesh* mesh = nullptr;                     // none: no surface was asked for
};

// What cannot be said, and why not.
struct LeftOut {
    std::string metric;
    std::string reason;
};

// How accurate a reconstruction is by what it knows itself, without truth. Bounds hold in 95 of 100
// dives. Where loops were closed and the final trajectory misses them by more than their own
// sigma, covariances are taken to be too small by as much.
struct ExpectedAccuracy {
    std::optional<double> end_bound_m;      // position of the last pose relative to the first pose
    std::optional<double> end_expected_m;   // its root mean square over many such dives
    std::optional<double> ate_bound_m;      // RMS over all frames after the best SE(3) of positions
    std::optional<double> ate_expected_m;   // its root mean square over many such dives
    std::optional<double> loop_residual_m;  // RMS over the loops that were closed
    std::optional<double> covariance_scale;  // of standard deviations, by the loops
    std::optional<ScaleCheck> accelerometer;
    std::optional<ScaleCheck> pressure;
    std::optional<ScaleCheck> known_distances;
    std::optional<double> imu_vision_disagreement_deg;  // RMS per frame
    std::optional<double> reprojection_rms_px;
    std::optional<ExpectedSurface> surface;
    std::optional<double> surface_shared_m;  // of its sigma, what the poses move all of it by
    std::vector<LeftOut> left_out;
    std::vector<Finding> findings;  // checks that contradict the cameras, bounds that are large
};

ExpectedAccuracy expected_accuracy(const ExpectedAccuracyInput& input);

nlohmann::json to_metrics(const ExpectedAccuracy& expected);

}  // namespace divemesh::evaluation
