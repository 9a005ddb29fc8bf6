#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "worker/dive/dive.hpp"
#include "worker/evaluation/surface_index.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/path_uncertainty.hpp"
#include "worker/types/pose_covariance.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/rig.hpp"
#include "worker/types/tracking_segment.hpp"

namespace divemesh::evaluation {

// A known distance and its measurement.
struct MeasuredDistance {
    std::string name;
    double known_m = 0.0;
    // nullopt: an end is marked in too few keyframes, or its marks do not determine a point
    std::optional<double> measured_m;
    std::optional<double> sigma_m;  // of measured_m; nullopt: the path's covariance is unknown
    int num_keyframes_a = 0;        // keyframes that show the end, or frames in which it is marked
    int num_keyframes_b = 0;
};

// scale_error = sum(m t) / sum(t t) - 1 over measured m and known t: the factor that best maps
// known to measured lengths, minus 1.
struct KnownDistanceErrors {
    std::vector<MeasuredDistance> distances;
    std::int64_t num_measured = 0;
    double scale_error = 0.0;
    double median_abs_error_m = 0.0;
    double rmse_m = 0.0;
    double max_abs_error_m = 0.0;
};

// A path and its uncertainty.
struct KnownPath {
    const types::Trajectory& trajectory;                // T_world_imu
    const types::CovarianceTrack& covariances;          // of the trajectory; empty: unknown
    double scale_sigma = types::kCalibrationSigma;      // of the path
    std::vector<types::TrackingSegment> segments = {};  // of the trajectory; empty: it is one
    double readout_time_s = 0.0;  // of a rolling shutter; the poses are those of the middle row
    // The part of scale_sigma that covers a contradiction of the scale: the covariances contain it
    // too, and it is no drift between the ends of a length.
    double contradiction_sigma = 0.0;
};

// Ground truth by which mark_point() finds the keyframes that show a point.
struct MarkingInput {
    const types::Rig& rig;
    const types::Trajectory& ground_truth;  // T_world_imu of the truth's world
    const std::vector<std::int64_t>& keyframe_timestamps_ns;
    const SurfaceIndex& reference;  // surface that may hide a point, in the truth's world
    double max_range_m = 4.0;
    double tolerance_m = 0.03;  // nominal ends may lie this far below or above the true surface
};

// Returns the true path of a body with the cameras mounted as on the estimated one. The mean
// rotation between both bodies gives the mounting. The true cameras took the images, so points must
// be marked where those saw them.
types::Trajectory with_mounting_of(const types::Trajectory& estimate,
                                   const types::Trajectory& ground_truth,
                                   const Eigen::Isometry3d& T_reference_estimate);

// Returns marks of a point in the keyframes that show it, for dives with ground truth: it must be
// inside the left image at the true pose, in range, on the reference mesh and not hidden by it.
std::vector<dive::Mark> mark_point(const Eigen::Vector3d& p_world, const MarkingInput& input);

// Triangulates a point, each mark seen from where the camera was when its row was read: least
// squares over the rays of both cameras, then Gauss-Newton on the reprojection error. Returns
// nullopt if fewer than `min_keyframes` of the marks have a pose, the rays do not determine a
// point, or the iterations do not converge in front of the cameras.
std::optional<Eigen::Vector3d> triangulate(const std::vector<dive::Mark>& marks,
                                           const types::Rig& rig,
                                           const types::Trajectory& trajectory,
                                           int min_keyframes = 4,
                                           double readout_time_s = 0.0);

// Measures each known distance as in photogrammetry: both ends are marked, triangulated with our
// poses and subtracted. Both are measured in the segment of the path that has the most marks of
// them, as nothing is known between two segments, and in frames that show both if four do. Ends
// given as points are marked by means of `truth`; if it is null they count as not measured. The
// sigma of a length covers the scatter of the marks, the drift of the path between the times at
// which its two ends were seen (an end rotates with the path about the place from which it was
// seen), and the path's scale_sigma of the length.
KnownDistanceErrors measure_known_distances(const std::vector<dive::KnownDistance>& distances,
                                            const MarkingInput* truth,
                                            const types::Rig& rig,
                                            const KnownPath& path);

nlohmann::json to_metrics(const KnownDistanceErrors& errors);

}  // namespace divemesh::evaluation
