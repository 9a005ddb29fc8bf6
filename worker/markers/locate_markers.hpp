#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "worker/markers/marker_metrics.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/pose_covariance.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::markers {

// A tag in one rectified picture of a keyframe.
struct TagView {
    int id = 0;
    std::size_t keyframe = 0;  // index
    bool is_right = false;
    std::array<Eigen::Vector2d, dive::kNumTagCorners> corners_px;
};

// The reconstruction that the views are laid into.
struct MarkerWorld {
    const types::RectifiedRig& rig;
    const std::vector<types::Keyframe>& keyframes;
    const types::Trajectory& trajectory;        // T_world_imu, final
    const types::CovarianceTrack& covariances;  // of the same; empty: not known
};

inline constexpr int kMinMarkerKeyframes = 3;

// Every tag that at least kMinMarkerKeyframes keyframes of a piece show in one place. Views are
// sorted out first (what two of them say, the others agree with or not), then each corner is the
// point of least reprojection error, poses held. The corners' covariance is White's (1980) over
// keyframes, with the correlation of neighbouring ones (Newey and West, 1987): a pose that is
// slightly off shifts all it sees; added to what a reading error of 0.1 px and more would do.
std::vector<Marker> locate_markers(std::vector<TagView> views, const MarkerWorld& world);

// Growth of the variance of the position per metre swum, at its fastest; m^2/m.
double drift_rate(const MarkerWorld& world);

}  // namespace divemesh::markers
