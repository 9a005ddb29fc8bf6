#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "worker/camera/shutter_correction.hpp"
#include "worker/markers/marker_metrics.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/pose_covariance.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::markers {

// A tag in one rectified image of a keyframe.
struct TagView {
    int id = 0;
    std::size_t keyframe = 0;  // index
    bool is_right = false;
    std::array<Eigen::Vector2d, dive::kNumTagCorners> corners_px;
};

// The reconstruction in which markers are located.
struct MarkerWorld {
    const types::RectifiedRig& rig;
    const std::vector<types::Keyframe>& keyframes;
    const types::Trajectory& trajectory;                 // T_world_imu, final
    types::CovarianceTrack covariances;                  // of the same; empty: unknown
    const camera::ShutterCorrection* shutter = nullptr;  // null: all rows are read at once
};

inline constexpr int kMinMarkerKeyframes = 3;

// Returns every tag that at least kMinMarkerKeyframes keyframes of a tracking segment see in one
// place. Outlier views are removed first (two views give a hypothesis that the others confirm or
// not), then each corner is triangulated for the least reprojection error with fixed poses. The
// corners' covariance is White's (1980) over keyframes, with the correlation of neighbouring ones
// (Newey and West, 1987), because a pose that is slightly off shifts all that it sees; the effect
// of a reading error of at least 0.1 px is added.
std::vector<Marker> locate_markers(std::vector<TagView> views, const MarkerWorld& world);

// Returns the fastest growth of the position's variance per metre travelled, m^2/m.
double drift_rate(const MarkerWorld& world);

}  // namespace divemesh::markers
