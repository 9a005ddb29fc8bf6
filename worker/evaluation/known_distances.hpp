#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "worker/dive/dive.hpp"
#include "worker/evaluation/surface_index.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/pose_covariance.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/rig.hpp"

namespace divemesh::evaluation {

// Of all lengths: baseline and focal length of a careful calibration.
inline constexpr double kCalibrationSigma = 0.001;

struct MeasuredDistance {
    std::string name;
    double known_m = 0.0;
    std::optional<double> measured_m;  // nothing: an end is marked in too few keyframes
    std::optional<double> sigma_m;     // of it; nothing: the path's covariance is not known
    int num_keyframes_a = 0;           // that show the end, or frames it is marked in
    int num_keyframes_b = 0;
};

// scale_error = sum(m t) / sum(t t) - 1 over measured m and known t: the one factor that maps
// known onto measured lengths best.
struct KnownDistanceErrors {
    std::vector<MeasuredDistance> distances;
    std::int64_t num_measured = 0;
    double scale_error = 0.0;
    double median_abs_error_m = 0.0;
    double rmse_m = 0.0;
    double max_abs_error_m = 0.0;
};

// A path, and how well it is known.
struct KnownPath {
    const types::Trajectory& trajectory;        // T_world_imu
    const types::CovarianceTrack& covariances;  // of it; empty: not known
};

struct MarkingInput {
    const types::Rig& rig;
    const types::Trajectory& ground_truth;  // T_world_imu of the truth's world
    const std::vector<std::int64_t>& keyframe_timestamps_ns;
    const SurfaceIndex& reference;  // what may hide a point; the truth's world
    double max_range_m = 4.0;
    double tolerance_m = 0.03;  // nominal ends may lie this far below or above the true surface
};

// The keyframes that show a point, for dives whose truth is known: inside the left image under the
// true pose, in range, not hidden by the reference mesh, and on it.
std::vector<dive::Mark> mark_point(const Eigen::Vector3d& p_world, const MarkingInput& input);

// Least squares over the rays of both cameras, then Gauss-Newton over reprojection. Nothing when
// fewer than `min_keyframes` of the marks have a pose, or the rays do not fix a point.
std::optional<Eigen::Vector3d> triangulate(const std::vector<dive::Mark>& marks,
                                           const types::Rig& rig,
                                           const types::Trajectory& trajectory,
                                           int min_keyframes = 4);

// Each known distance as a photogrammetrist would take it: both ends marked, triangulated with our
// poses, subtracted. Ends that are given as points are marked with the help of `truth`; without it
// they count as not measured. The sigma of a length holds the scatter of the marks, what the path
// drifted between the times at which its two ends were seen (an end turns with the path about where
// it was seen from), and kCalibrationSigma of the length.
KnownDistanceErrors measure_known_distances(const std::vector<dive::KnownDistance>& distances,
                                            const MarkingInput* truth,
                                            const types::Rig& rig,
                                            const KnownPath& path);

nlohmann::json to_metrics(const KnownDistanceErrors& errors);

}  // namespace divemesh::evaluation
